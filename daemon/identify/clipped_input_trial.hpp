// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/identify/identification.hpp"
#include "daemon/identify/input_trial.hpp"

namespace eha::identify {

/// Whether simple models err at most half as much behind an input that goes on where the recorded one stands exactly at
/// its ends (ident::clipped_input(), clipped_levels()): smoothly, or at levels that follow from the output.
/// Cost, none for another input: four local fits of each model on 20 000 rows, or ten of a staircase.
[[nodiscard]] std::optional<WrongInput> of_clipped_input(const Source& source, const IdentificationTask& task,
                                                         const std::vector<const IdentifiedModel*>& bases);

/// That the input of a file stands exactly at its ends beside a first model that misses something, where no trial tells
/// whether the plant got more; empty otherwise. Cost O(N).
[[nodiscard]] std::string may_be_clipped(const Source& source, const IdentificationTask& task,
                                         const Identification& identification);

}  // namespace eha::identify
