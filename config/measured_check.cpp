// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/measured_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "core/journal_block.hpp"
#include "hal/backends/backend.hpp"

namespace eha::config {
namespace {

std::uint32_t sum_of(const std::string& text) { return journal::Crc32c().add(text.data(), text.size()).value(); }

}  // namespace

std::uint32_t measured_check_of(const Following& following) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  return sum_of(fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g}", following.gain_positive_in_per_V_s,
                            following.gain_negative_in_per_V_s, following.null_V, following.dead_band_V,
                            following.null_uncertainty_V.value_or(kUnknown),
                            following.dead_band_uncertainty_V.value_or(kUnknown),
                            following.gain_uncertainty_percent.value_or(kUnknown)));
}

std::uint32_t measured_rig_check_of(const hal::Backend& backend) {
  const hal::Conversion conversion = hal::conversion_of(backend);
  return sum_of(
      fmt::format("{} {:.6g} {:.6g}", hal::wiring_of(backend), conversion.scale_in_per_V, conversion.offset_in));
}

bool is_as_measured(const RigConfig& rig) {
  const std::optional<Following>& following = rig.limits.following;
  return following && following->measured_check && following->measured_rig_check &&
         *following->measured_check == measured_check_of(*following) &&
         *following->measured_rig_check == measured_rig_check_of(rig.backend);
}

bool shows_motion_first(const RigConfig& rig) {
  return hal::moves_machine(rig.backend) && rig.limits.following && !is_as_measured(rig);
}

double showing_way_in(const RigLimits& limits, double place_in) {
  constexpr double kMostOfTravel = 0.1;
  const double travel_in = limits.travel_max_in - limits.travel_min_in;
  return std::copysign(std::min(kShowing_in, kMostOfTravel * travel_in),
                       limits.travel_min_in + 0.5 * travel_in - place_in);
}

}  // namespace eha::config
