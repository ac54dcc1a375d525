// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "ident/model/model_node.hpp"
#include "ident/structure/structure_options.hpp"

namespace eha::ident {

/// The structure of a model as the member `structure` of its file: each parameter with value, freedom and bounds, and
/// the requests that were made. Infinite bounds and what a structure lacks are left out.
[[nodiscard]] nlohmann::ordered_json structure_to_json(const StructureOptions& asked);

/// Reads what structure_to_json() writes; the name is left to the caller.
/// @throws ConfigError  names file and path of a wrong member
[[nodiscard]] StructureOptions read_structure(const ModelNode& node);

}  // namespace eha::ident
