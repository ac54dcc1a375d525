// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/eha/identification.hpp"

namespace eha::cli {

/// Estimates every structure on every repetition and scores it on the others. Each model is simulated from the record's
/// first row on, whichever repetition is compared: no history is cut off; an initial
/// state is estimated on the first repetition only. The discarded time counts from the first row.
/// @param repetition_samples  rows of one repetition; those of an unfinished last one are left out
/// @throws DataError    fewer than two repetitions, or one too short to estimate from
/// @throws UsageError   the task is by the paper's procedure, which has no history to keep
/// Cost: a fit for each structure and repetition.
[[nodiscard]] std::vector<CrossValidatedModel> cross_validate(const IdentificationTask& task,
                                                              std::size_t repetition_samples, Console& console);

/// R2 on each repetition, one row for each structure and repetition that estimated it.
[[nodiscard]] std::string cross_validation_table(const std::vector<CrossValidatedModel>& models);
[[nodiscard]] nlohmann::ordered_json cross_validation_json(const std::vector<CrossValidatedModel>& models);

}  // namespace eha::cli
