// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "config/toml_section.hpp"
#include "ident/fit_options.hpp"
#include "ident/structure/structure_options.hpp"

namespace eha::config {

/// Reads the array of tables `[[model]]`; adds an issue for each error.
[[nodiscard]] std::vector<ident::StructureOptions> read_models(Section& root, Document& document);

/// Reads one model from a file of its own, with the keys of `[[model]]` at the top level. `name` and `structure` are
/// optional (default "terms").
[[nodiscard]] ident::StructureOptions read_single_model(Section& root, Document& document);

/// Adds errors that the estimator would report only after the experiment: unknown parameters, held ones without a
/// value, a past input together with zeros, options that the procedure does not have.
void check_models(const std::vector<ident::StructureOptions>& models, ident::Procedure procedure, Document& document);

/// The same for one model, whose keys have the path `path`; empty for the top level.
void check_model(const ident::StructureOptions& model, const std::string& path, Document& document);

}  // namespace eha::config
