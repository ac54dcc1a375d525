// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/excitation_room.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/valve_estimate.hpp"
#include "core/error.hpp"

namespace eha::cli {
namespace {

constexpr double kShareOfVolts = 0.88;   ///< of the remaining range beside the null: a hold needs the rest
constexpr double kShareOfSlew = 0.95;    ///< the rounding of amplitudes and the hold
constexpr double kShareOfTravel = 0.75;  ///< below the 80 % at which the tick warns
constexpr double kSlow_s = 0.04;
constexpr double kFast_s = 0.005;
constexpr double kHighestSlow_Hz = 1.0 / (10.0 * kSlow_s);  ///< ten compared rows in a period

}  // namespace

ExcitationRoom excitation_room(const config::RigConfig& rig) {
  if (!rig.limits.following) {
    throw ConfigError(
        fmt::format("{}: no [following], which predicts the travel of the tones; see eha-rig(5)", rig.file_name));
  }
  const config::ValveEstimate valve = config::valve_estimate(*rig.limits.following);
  const config::RigLimits& limits = rig.limits;
  return {.peak_V = kShareOfVolts * std::min(limits.command_max_V - valve.null_V, valve.null_V - limits.command_min_V),
          .slew_V_per_s = kShareOfSlew * limits.slew_V_per_s,
          .travel_in = 0.5 * kShareOfTravel * (limits.travel_max_in - limits.travel_min_in),
          .gain_in_per_V_s = 0.5 * (valve.gain_positive_in_per_V_s + valve.gain_negative_in_per_V_s),
          .null_V = valve.null_V,
          .dead_band_V = valve.dead_band_V};
}

int compared_ticks(double highest_Hz, double tick_s) {
  const double step_s = highest_Hz > kHighestSlow_Hz ? kFast_s : kSlow_s;
  return std::max(1, static_cast<int>(std::lround(step_s / tick_s)));
}

void warn_of_dead_band(double rms_V, const ExcitationRoom& room, Console& console) {
  constexpr double kFewestBands = 3.0;
  if (rms_V >= kFewestBands * room.dead_band_V) return;
  console.warning(fmt::format(
      "the tones have {:.3g} V RMS, half the dead band {:.3g} V: measured gains will be too low; a narrower "
      "band or a shorter period allows larger tones",
      rms_V, room.dead_band_V));
}

}  // namespace eha::cli
