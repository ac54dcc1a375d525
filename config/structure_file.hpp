// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "ident/structure/structure_options.hpp"

namespace eha::config {

/// Reads a model structure from a TOML file: the keys of an experiment's `[[model]]` at the top level. `structure` and
/// `name` are optional (default "terms").
/// @throws ConfigError      every fault, each with line and column
/// @throws PermissionError  the file may not be read
[[nodiscard]] ident::StructureOptions load_structure(const std::string& path);

/// Reads a structure from text in memory; file_name is used in messages only.
[[nodiscard]] ident::StructureOptions parse_structure(std::string_view text, const std::string& file_name);

}  // namespace eha::config
