// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/identify/identification.hpp"

namespace eha::cli {

/// Writes R2 on each repetition, one row for each structure and repetition that estimated it.
[[nodiscard]] std::string cross_validation_table(const std::vector<identify::CrossValidatedModel>& models);
[[nodiscard]] nlohmann::ordered_json cross_validation_json(const std::vector<identify::CrossValidatedModel>& models);

}  // namespace eha::cli
