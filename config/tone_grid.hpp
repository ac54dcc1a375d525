// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "config/experiment_config.hpp"

namespace eha::config {

/// Returns a sentence on the tones that are not periodic in what is used of the record, with the nearest frequencies
/// that are, or the length that the slowest one needs: multiples of 1 / duration_s with two or more repetitions,
/// otherwise of twice the reciprocal of what is left after discard_s. Such a tone is played and fitted, but no line of
/// the measured frequency response. None for kinds without tones, and where all tones repeat twice within what is used
/// of one repetition.
[[nodiscard]] std::optional<std::string> off_grid_tones(const ExperimentConfig& experiment);

}  // namespace eha::config
