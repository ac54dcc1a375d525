// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "ident/model/model_node.hpp"
#include "ident/structure/structure_options.hpp"

namespace eha::ident {

/// Writes the structure of a model as the member `structure` of its file: each parameter with value, freedom and
/// bounds, and the user's requests. Infinite bounds and absent parts are left out.
[[nodiscard]] nlohmann::ordered_json structure_to_json(const StructureOptions& asked);

/// Reads the output of structure_to_json(); the caller sets the name.
/// @throws ConfigError  names file and path of a wrong member
[[nodiscard]] StructureOptions read_structure(const ModelNode& node);

}  // namespace eha::ident
