// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/limit_checks.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

namespace eha::doctor {
namespace {

// No standard gives these. They are far outside what a cylinder of this kind does, so a good rig file never reaches
// them.
constexpr double kLongestFrozen_s = 2.0;
constexpr double kShortestCrossing_s = 0.1;                     ///< of the whole travel, at the highest allowed speed
constexpr double kGreatestDeceleration_in_per_s2 = 10 * 386.1;  ///< ten times gravity
constexpr double kLongestLate_s = 0.1;

}  // namespace

Check check_limits(const config::RigLimits& limits, const config::RealtimeOptions& realtime) {
  std::vector<std::string> loose;
  if (limits.frozen_sensor_s <= 0.0) {
    loose.emplace_back("limits.frozen_sensor_s is off: a stuck sensor is not detected");
  } else if (limits.frozen_sensor_s > kLongestFrozen_s) {
    loose.push_back(fmt::format("limits.frozen_sensor_s = {:g} s: a stuck sensor is not detected for as long",
                                limits.frozen_sensor_s));
  }
  const double crossing_s = (limits.travel_max_in - limits.travel_min_in) / limits.velocity_limit_in_per_s;
  if (crossing_s < kShortestCrossing_s) {
    loose.push_back(
        fmt::format("limits.velocity_limit_in_per_s = {:g} in/s: the rod may cross its whole travel in {:.2g} s",
                    limits.velocity_limit_in_per_s, crossing_s));
  }
  if (limits.stopping_deceleration_in_per_s2 > kGreatestDeceleration_in_per_s2) {
    loose.push_back(
        fmt::format("limits.stopping_deceleration_in_per_s2 = {:g} in/s^2 is over ten times gravity: no stopping "
                    "distance is kept",
                    limits.stopping_deceleration_in_per_s2));
  }
  const double late_s = realtime.abort_consecutive_late * realtime.sample_period_s;
  if (late_s > kLongestLate_s) {
    loose.push_back(fmt::format("realtime.abort_consecutive_late = {}: the loop may be late for {:.2g} s in a row",
                                realtime.abort_consecutive_late, late_s));
  }
  if (loose.empty()) return ok("limits", "travel, speed, stuck sensor and late loop are watched");
  return warn("limits", fmt::format("{}", fmt::join(loose, "\n")),
              "set what the rig needs; rigs/pci1716.toml gives a start, eha-rig(5) the meaning");
}

}  // namespace eha::doctor
