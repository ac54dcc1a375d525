// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "config/toml_section.hpp"
#include "ident/estimation/fit_options.hpp"

namespace eha::config {

/// One day; a longer time has a wrong unit.
inline constexpr double kLongestRun_s = 86400.0;

/// Reads the array of tables `[[model]]`; adds an issue for each error.
[[nodiscard]] std::vector<ident::StructureOptions> read_models(Section& root, Document& document);

/// Reads one model that stands in a file of its own: the keys of `[[model]]` at the top level, of which `name` and
/// `structure` may be left out ("terms").
[[nodiscard]] ident::StructureOptions read_single_model(Section& root, Document& document);

/// Adds what the estimator would refuse after the experiment: names of parameters, held ones without a value, a past
/// input beside zeros, what the procedure does not know.
void check_models(const std::vector<ident::StructureOptions>& models, ident::Procedure procedure, Document& document);

/// The same for one model, whose keys have the path `path`; empty for the top level.
void check_model(const ident::StructureOptions& model, const std::string& path, Document& document);

}  // namespace eha::config
