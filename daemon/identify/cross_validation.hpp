// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "daemon/identify/identification.hpp"

namespace eha::identify {

/// Estimates every structure on every repetition and scores it on the others. Simulates each model from the record's
/// first row on, so that no history is lost. An initial state is estimated on the first repetition only. The
/// discarded time counts from the first row; an unfinished last repetition is left out.
/// @throws DataError    fewer than two repetitions, or one too short to estimate from
/// @throws UsageError   the task is by the paper's procedure, which has no history to keep
/// Cost: a fit for each structure and repetition.
[[nodiscard]] std::vector<CrossValidatedModel> cross_validate(const IdentificationTask& task, const Progress& progress);

/// Returns the mean R2 of the repetitions that did not estimate [%].
[[nodiscard]] double mean_r2_percent(const std::vector<ident::Score>& scores, std::size_t estimated_on);

}  // namespace eha::identify
