// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "daemon/tune/tune_inputs.hpp"

namespace eha::tune {

/// From this factor on, either way, two velocity gains are not of one plant: dry friction and a dead band shift the
/// gain of a fitted model by less.
inline constexpr double kOtherGain = 1.5;

/// The model's gain over that of the simulated rig on which its controller is tried, or of [following]; none where the
/// rig's is not known, or where they differ by less than kOtherGain.
[[nodiscard]] std::optional<double> gain_mismatch(const TuneInputs& inputs);

/// The time constant of a model that does not integrate within its band, so that volts set a place there and no speed;
/// none for the model of a rod that keeps moving. [s]
[[nodiscard]] std::optional<double> returns_in_s(const TuneInputs& inputs);

/// Why the trials' cylinder is not the plant of the model: gain or lag; empty where neither shows it.
[[nodiscard]] std::string why_another_plant(const TuneInputs& inputs);

}  // namespace eha::tune
