// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/limit_remarks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

#include "config/measured_check.hpp"
#include "config/placing_speed.hpp"
#include "config/valve_estimate.hpp"
#include "core/millimetre_key.hpp"
#include "hal/backends/backend.hpp"

namespace eha {
namespace {

constexpr double kLetPass_V = 0.1;  // beyond the edge of a simulated valve
constexpr double kLongestFrozen_s = 2.0;
constexpr double kLongestLateLoop_s = 0.1;
constexpr double kMostUnknownShare = 0.1;  ///< of half the command range, of a safe voltage at a null that is not known
constexpr std::chrono::days kLongestCalibrated{366};

std::string frozen_sensor(const config::RigLimits& limits) {
  if (limits.frozen_sensor_s <= 0.0) {
    return "limits.frozen_sensor_s is off: a stuck sensor is not detected; set 0.5, the seconds after which a driven "
           "rod's reading that stands still trips";
  }
  if (limits.frozen_sensor_s <= kLongestFrozen_s) return {};
  return fmt::format("limits.frozen_sensor_s = {:g} s: a stuck sensor stays undetected for that long; set 0.5",
                     limits.frozen_sensor_s);
}

std::string late_following(const config::RigLimits& limits) {
  constexpr double kUsual_in = 0.1;
  if (!limits.following || limits.following->limit_in <= kUsual_in) return {};
  return fmt::format(
      "following.limit_in = {:g} in ({:.3g} mm): beside a dead sensor the rod moves by up to four times as much "
      "unseen; "
      "set {:g} in, unless a sound rig trips with it",
      limits.following->limit_in, kMillimetresPerInch * limits.following->limit_in, kUsual_in);
}

std::string late_loop(const config::RealtimeOptions& realtime) {
  const double late_s = realtime.abort_consecutive_late * realtime.sample_period_s;
  if (late_s <= kLongestLateLoop_s) return {};
  return fmt::format(
      "realtime.abort_consecutive_late = {}: the loop may be late for {:.2g} s in a row; set at most {:g}",
      realtime.abort_consecutive_late, late_s,
      std::max(1.0, std::floor(kLongestLateLoop_s / realtime.sample_period_s)));
}

/// A placing moves at a tenth of the velocity limit at most.
std::string slow_placing(config::RigLimits limits) {
  const double limit_in_per_s = limits.velocity_limit_in_per_s;
  const double speed_in_per_s = config::placing_speed_in_per_s(limits);
  limits.velocity_limit_in_per_s = std::numeric_limits<double>::max();
  const double usual_in_per_s = config::placing_speed_in_per_s(limits);
  if (limit_in_per_s >= usual_in_per_s) return {};
  return fmt::format(
      "limits.velocity_limit_in_per_s = {0:g} in/s ({1:.3g} mm/s) is below the usual {2:g} in/s ({3:.3g} mm/s) of "
      "goto, which moves at a tenth of the limit: 1 in (25.4 mm) takes {4:.3g} s, and most experiments trip; set what "
      "the rig needs, {5:g} or more where goto is to have its usual speed",
      limit_in_per_s, kMillimetresPerInch * limit_in_per_s, usual_in_per_s, kMillimetresPerInch * usual_in_per_s,
      1.0 / speed_in_per_s, usual_in_per_s * limit_in_per_s / speed_in_per_s);
}

/// The day of "2026-01-31"; none of another text, as of a rig that needs no calibration.
std::optional<std::chrono::sys_days> day_of(const std::string& text) {
  int year = 0;
  unsigned month = 0;
  unsigned day = 0;
  if (std::sscanf(text.c_str(), "%d-%u-%u", &year, &month, &day) != 3) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(month), std::chrono::day(day)};
  return date.ok() ? std::optional(std::chrono::sys_days(date)) : std::nullopt;
}

std::string old_calibration(const std::string& date, std::chrono::sys_days today) {
  const auto calibrated = day_of(date);
  if (!calibrated || today - *calibrated <= kLongestCalibrated) return {};
  return fmt::format(
      "calibration_date = \"{}\": scale and offset of the sensor are {:.1f} years old; hold a ruler to the rod beside "
      "`eha read` at two places, and where they differ by more than 0.5 mm (0.02 in) `eha calibrate`; where they agree "
      "write today's date",
      date, static_cast<double>((today - *calibrated).count()) / 365.25);
}

/// A voltage at which the rod moves while nothing drives it. Its bounds for a machine are arming_findings()'.
std::string moving_at_rest(const config::RigConfig& rig) {
  const config::RigLimits& limits = rig.limits;
  const auto& following = limits.following;
  if (!following) {
    const double away_V = std::abs(limits.safe_V);
    const double most_V = kMostUnknownShare * 0.5 * (limits.command_max_V - limits.command_min_V);
    if (away_V <= most_V) return {};
    return fmt::format(
        "limits.safe_V = {:g} V may be outside the valve's dead band, which is not known: the rod would "
        "move with nothing driving it; set 0, or the valve's null once it is measured",
        limits.safe_V);
  }
  const config::ValveEstimate valve = config::valve_estimate(*following);
  const double away_V = std::abs(limits.safe_V - valve.null_V);
  const double speed_in_per_s = std::abs(valve.velocity_in_per_s(limits.safe_V));
  // On a simulated rig, where nobody is hurt, a creep is let pass.
  const double edge_V = valve.dead_band_V + (hal::moves_machine(rig.backend) ? 0.0 : kLetPass_V);
  if (away_V <= edge_V || !(speed_in_per_s > 0.0)) return {};
  return fmt::format(
      "limits.safe_V = {:g} V is {:.3g} V from the valve's null, outside its half dead band of {:.3g} V: the rod moves "
      "at about {:.2g} in/s ({:.2g} mm/s) where the hydraulics are on and nothing drives it; {}",
      limits.safe_V, away_V, valve.dead_band_V, speed_in_per_s, kMillimetresPerInch * speed_in_per_s,
      config::is_as_measured(rig)
          ? fmt::format("set {:g}, the null", valve.null_V)
          : fmt::format("measure the valve (`eha characterise`) before you believe that {:g} is the null and set it",
                        valve.null_V));
}

}  // namespace

std::vector<std::string> limit_remarks(const config::RigConfig& rig, std::chrono::sys_days today) {
  std::vector<std::string> remarks{frozen_sensor(rig.limits), slow_placing(rig.limits), late_following(rig.limits),
                                   old_calibration(hal::conversion_of(rig.backend).calibration_date, today),
                                   moving_at_rest(rig)};
  // No loop of a simulated rig moves anything while it is late.
  if (hal::moves_machine(rig.backend)) remarks.push_back(late_loop(rig.realtime));
  std::erase(remarks, "");
  return remarks;
}

std::vector<std::string> limit_remarks(const config::RigConfig& rig) {
  return limit_remarks(rig, std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now()));
}

}  // namespace eha
