// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>

#include "daemon/eha/console.hpp"

namespace eha::cli {

/// Prints the models of a run as its manifest lists them (identification.models): a table, then what there is to say
/// about each. Members that are missing or of another kind show as "-".
void print_model_list(const nlohmann::ordered_json& models, const Console& console);

}  // namespace eha::cli
