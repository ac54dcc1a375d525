// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/tune/promised_plant.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/millimetre_key.hpp"

namespace eha::tune {

std::optional<double> gain_mismatch(const TuneInputs& inputs) {
  if (!inputs.rig_gain_in_per_V_s) return std::nullopt;
  const double ratio = inputs.model_gain_in_per_V_s / *inputs.rig_gain_in_per_V_s;
  if (ratio < kOtherGain && ratio > 1.0 / kOtherGain) return std::nullopt;
  return ratio;
}

std::optional<double> returns_in_s(const TuneInputs& inputs) {
  const double return_rad_s = inputs.plant.inverse.position;  // of a plant whose velocity gain is 1
  const double lowest_rad_s = 2.0 * std::numbers::pi * inputs.lowest_Hz;
  if (!(lowest_rad_s > 0.0) || return_rad_s < lowest_rad_s) return std::nullopt;
  return 1.0 / return_rad_s;
}

std::string why_another_plant(const TuneInputs& inputs) {
  std::string text;
  if (const auto lag_s = returns_in_s(inputs)) {
    text = fmt::format(
        "within its band the model does not integrate, so that volts set a place (after a lag of {:.3g} s), where the "
        "rod of a cylinder keeps moving",
        *lag_s);
  }
  const auto ratio = gain_mismatch(inputs);
  if (!ratio) return text;
  constexpr double kNear = 0.1;
  const auto is_near = [](double value, double factor) { return std::abs(value / factor - 1.0) < kNear; };
  const double factor = inputs.task.unit.factor("in");
  text += fmt::format("{}the model moves the rod {:.3g} {}/s for each volt, {} {:.3g}: {:.2g} times that",
                      text.empty() ? "" : "; ", factor * inputs.model_gain_in_per_V_s, inputs.task.unit.of("in"),
                      inputs.rig_gain_of, factor * *inputs.rig_gain_in_per_V_s, *ratio);
  if (is_near(*ratio, kMillimetresPerInch) || is_near(*ratio, 1.0 / kMillimetresPerInch))
    text += ", as with mm taken for inches";
  return text;
}

}  // namespace eha::tune
