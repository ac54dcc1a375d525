// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/arming.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>

#include "config/measured_check.hpp"
#include "config/needs_following.hpp"
#include "config/valve_estimate.hpp"
#include "core/error.hpp"
#include "core/millimetre_key.hpp"
#include "daemon/acquisition/circuits_at_rest.hpp"
#include "daemon/acquisition/following_monitor.hpp"
#include "daemon/rig/realtime_findings.hpp"
#include "hal/backends/backend.hpp"

namespace eha {
namespace {

// No standard defines these. They are far beyond the motions of a cylinder of this kind, so that a sound rig file never
// reaches them.
constexpr double kReadBeyondRange = 0.02;                       // of its range: an input reads up to its rail
constexpr double kShortestCrossing_s = 0.1;                     ///< of the whole travel, at the highest allowed speed
constexpr double kShortestSweep_s = 0.01;                       ///< of the whole command range, at the slew limit
constexpr double kLongestRampOut_s = 2.0;                       ///< of a stop, from the farthest command
constexpr double kGreatestDeceleration_in_per_s2 = 10 * 386.1;  ///< ten times gravity
constexpr double kGreatestSafeShare = 0.1;                      ///< of half the command range, from the valve's null
constexpr double kGreatestUnswitchedShare = 0.02;               ///< the same without an enable line, valve not measured
/// Of the rod while the safe voltage stands with the hydraulics on, 0.1 s at each arming: what a placing promises.
constexpr double kGreatestSafeSpeed_in_per_s = 0.3;
/// The same without an enable line, where nothing watches the rod, by numbers that nothing shows to be measured.
constexpr double kGreatestUnwatchedSpeed_in_per_s = 0.1;
constexpr double kGreatestDeadBandShare = 0.3;    ///< of half the command range
constexpr double kGreatestFollowingShare = 0.05;  ///< of the travel
constexpr double kGreatestSpeedInDeadBand_in_per_s = 1.0;
// The command stands at null_V, or is taken from there, before a sensor that is dead from the start shows. Pinned by
// slip_campaign_test.cpp.
constexpr double kUsualNull_V = 0.3;                   ///< of a valve of which nothing is known, from 0 V
constexpr double kGreatestSpeedAtNull_in_per_s = 0.6;  ///< beside a placing's first volts
constexpr double kGreatestWayAtNull_in = 0.1;          ///< until the pressure has built up
constexpr double kLongestPressureDelay_s = 3.0;
constexpr double kGreatestGainRatio = 5.0;  ///< of one direction to the other, of a rod that no load moves
constexpr double kLeastGainShare = 0.01;    ///< of the velocity limit, at half the command range
/// Half of a gain [in/(V s)]. A number in another unit is 10 or 25.4 times too small, and lets a dead sensor pass:
/// pinned by slip_campaign_test.cpp.
constexpr double kLeastUnmeasuredGain_in_per_V_s = 0.05;
/// Of the travel, below which a file speaks of another unit than it means: 25.4 times too small, it is 4 % or 6 mm.
constexpr double kLeastTravelShare = 0.1;  ///< of what the sensor shows
constexpr double kLeastTravel_mm = 10.0;

constexpr int kReadings = 20;
/// Between two readings [s]. A sensor that drifts is seen, and no harmonic of the mains always at the same phase.
constexpr double kReadingPeriod_s = 0.023;
constexpr double kShortTick_s = 0.001;
constexpr double kRangeOfMeasured_in = 0.06;
constexpr double kRangeOfUnmeasured_in = 0.025;
constexpr double kSpread = 3.7;  // mean range of so many normal readings over their standard deviation

constexpr const char* kChangedNumber =
    "following.measured_check does not fit: a measured number of [following] was changed after its measurement; put "
    "the lines of the sheet into the file again, or measure anew (`eha characterise`)";

constexpr const char* kChangedRig =
    "following.measured_rig_check does not fit: the numbers of [following] were measured with another card, other "
    "channels or another calibration of the sensor (`eha calibrate` takes them along); remove [following] and "
    "measure this rig (`eha characterise`)";

constexpr const char* kChangedBoth =
    "following.measured_check and measured_rig_check do not fit: since [following] was measured card, channels or the "
    "sensor's calibration have changed, and its numbers, too (`eha calibrate` changes both where the scale changes by "
    "more than 1.5 times), so that no earlier sheet holds: `eha characterise --without-following -o "
    "rig-bare.toml` and its Next measure it anew";

constexpr const char* kMeasureIt =
    "measure it (`eha characterise`, or the same with the run of an earlier one) and take its lines with "
    "measured_check and measured_rig_check";

/// Whether a measured number is another one than the sum is of.
bool has_changed(const config::Following& following) {
  return following.measured_check && *following.measured_check != config::measured_check_of(following);
}

/// Says which sum does not fit, and what to do; none: both fit, or there is none.
const char* changed_since_measured(const config::RigConfig& rig) {
  const config::Following& following = *rig.limits.following;
  const bool is_of_another_rig =
      following.measured_rig_check && *following.measured_rig_check != config::measured_rig_check_of(rig.backend);
  if (!has_changed(following)) return is_of_another_rig ? kChangedRig : nullptr;
  return is_of_another_rig ? kChangedBoth : kChangedNumber;
}

/// In either direction [in/(V s)]. The keys have half of it.
double greatest_gain(const config::Following& following) {
  return 2.0 * std::max(following.gain_positive_in_per_V_s, following.gain_negative_in_per_V_s);
}

/// A null and a dead band beside the command limits, so that no volts move the rod one way; empty for others.
std::string unreachable_valve(const config::RigLimits& limits) {
  if (!limits.following) return {};
  const double null_V = limits.following->null_V;
  const double dead_band_V = limits.following->dead_band_V;
  if (null_V - dead_band_V > limits.command_min_V && null_V + dead_band_V < limits.command_max_V) return {};
  return fmt::format(
      "following.null_V = {:g} V with dead_band_V = {:g} V: of the commands {:g}..{:g} V none moves the rod {}; "
      "correct it, or the command limits",
      null_V, dead_band_V, limits.command_min_V, limits.command_max_V,
      null_V - dead_band_V <= limits.command_min_V ? "towards smaller displacements" : "towards greater displacements");
}

/// Judges a null that nothing shows to be measured: its sign may be wrong, or the valve's null be where that of many
/// valves is.
void judge_null(const config::Following& following, std::vector<std::string>& refusals) {
  const double gain = greatest_gain(following);
  const double away_V = std::abs(following.null_V);
  if (const double speed = gain * 2.0 * away_V; speed > kGreatestSpeedAtNull_in_per_s) {
    refusals.push_back(fmt::format(
        "following.null_V = {:g} V: if the valve's null were {:g} V, the rod would move at {:.2g} in/s before a dead "
        "sensor shows; {}",
        following.null_V, -following.null_V, speed, kMeasureIt));
    return;
  }
  const double valves_V = std::copysign(std::max(away_V, kUsualNull_V), -following.null_V);
  const double speed = gain * (std::abs(following.null_V - valves_V) - following.dead_band_V);
  if (const double way_in = speed * following.pressure_delay_s; way_in > kGreatestWayAtNull_in) {
    refusals.push_back(fmt::format(
        "following.pressure_delay_s = {:g} s at null_V = {:g} V: if the valve's null were {:g} V, the rod would move "
        "{:.2g} in before a dead sensor shows; set at most {:.2g}, if the pressure is there by then, or {}",
        following.pressure_delay_s, following.null_V, valves_V, way_in, kGreatestWayAtNull_in / speed, kMeasureIt));
  }
}

/// Judges [following]: a wrong number makes a placing too fast, or lets a dead sensor pass.
void judge_following(const config::RigConfig& rig, double half_range_V, double travel_in,
                     std::vector<std::string>& refusals) {
  const config::RigLimits& limits = rig.limits;
  const config::Following& following = *limits.following;
  const bool is_as_measured = config::is_as_measured(rig);
  if (const char* changed = changed_since_measured(rig)) refusals.emplace_back(changed);
  if (const double most = kGreatestDeadBandShare * half_range_V; following.dead_band_V > most) {
    refusals.push_back(fmt::format(
        "following.dead_band_V = {:g} V is more than 30 % of half the command range, in which the sensor is "
        "not compared with the command; set what the valve has, at most {:.3g}, see FOLLOWING in eha-rig(5)",
        following.dead_band_V, most));
  }
  if (const double speed = greatest_gain(following) * following.dead_band_V;
      speed > kGreatestSpeedInDeadBand_in_per_s && !is_as_measured) {
    refusals.push_back(
        fmt::format("following.dead_band_V = {:g} V: if the valve had none, the rod would move at {:.2g} in/s before a "
                    "dead sensor shows; {}",
                    following.dead_band_V, speed, kMeasureIt));
  }
  if (!is_as_measured) judge_null(following, refusals);
  const auto [lower, higher] = std::minmax(following.gain_positive_in_per_V_s, following.gain_negative_in_per_V_s);
  if (higher > kGreatestGainRatio * lower && !is_as_measured) {
    refusals.push_back(fmt::format(
        "following.gain_positive_in_per_V_s = {:g} and gain_negative_in_per_V_s = {:g} in/(V s): no rod is "
        "{:.2g} times as fast one way as the other; {}",
        following.gain_positive_in_per_V_s, following.gain_negative_in_per_V_s, higher / lower, kMeasureIt));
  }
  if (const double most = kGreatestFollowingShare * travel_in; following.limit_in > most) {
    refusals.push_back(
        fmt::format("following.limit_in = {:g} in is more than 5 % of the travel; set 0.1, at most {:.3g}",
                    following.limit_in, most));
  }
  if (following.pressure_delay_s > kLongestPressureDelay_s) {
    refusals.push_back(
        fmt::format("following.pressure_delay_s = {:g} s keeps the following check off for too long; set "
                    "at most {:g}",
                    following.pressure_delay_s, kLongestPressureDelay_s));
  }
  const double least = kLeastGainShare * limits.velocity_limit_in_per_s / (2.0 * half_range_V);
  for (const auto& [key, half_gain] : {std::pair("gain_positive_in_per_V_s", following.gain_positive_in_per_V_s),
                                       std::pair("gain_negative_in_per_V_s", following.gain_negative_in_per_V_s)}) {
    if (half_gain < kLeastUnmeasuredGain_in_per_V_s && !is_as_measured) {
      refusals.push_back(fmt::format(
          "following.{} = {:g} in/(V s) is less than {:g}, with which a dead sensor would show late; mm for "
          "inches? If the rod is so slow, {}",
          key, half_gain, kLeastUnmeasuredGain_in_per_V_s, kMeasureIt));
      continue;
    }
    if (half_gain >= least) continue;
    refusals.push_back(
        fmt::format("following.{} = {:g} in/(V s) reaches less than 1 % of limits.velocity_limit_in_per_s at half the "
                    "command range; set half the measured gain, at least {:.3g}, or lower the velocity limit",
                    key, half_gain, least));
  }
}

/// Greatest difference of the safe voltage from the valve's null [V] if the hydraulics stay on, because the rod is then
/// not monitored.
double greatest_safe_V(const config::RigConfig& rig) {
  const config::RigLimits& limits = rig.limits;
  const double half_range_V = 0.5 * (limits.command_max_V - limits.command_min_V);
  const double dead_band_V = limits.following ? limits.following->dead_band_V : 0.0;
  if (hal::switches_hydraulics(rig.backend)) return std::max(dead_band_V, kGreatestSafeShare * half_range_V);
  // Measured, the dead band of [following] is wider than the valve's, within which the rod stands.
  if (config::is_as_measured(rig) && limits.following) return config::valve_estimate(*limits.following).dead_band_V;
  const double most_V = kGreatestUnswitchedShare * half_range_V;
  return limits.following ? std::min(dead_band_V, most_V) : most_V;
}

/// Judges a safe voltage that drives the valve.
void judge_safe_V(const config::RigConfig& rig, std::vector<std::string>& refusals) {
  const double null_V = rig.limits.following ? rig.limits.following->null_V : 0.0;
  const double most_V = greatest_safe_V(rig);
  const double away_V = std::abs(rig.limits.safe_V - null_V);
  if (away_V <= most_V) {
    if (!rig.limits.following) return;
    const config::Following& following = *rig.limits.following;
    const bool is_unwatched = !hal::switches_hydraulics(rig.backend) && !config::is_as_measured(rig);
    const double speed = greatest_gain(following) * (away_V - (is_unwatched ? 0.0 : following.dead_band_V));
    if (is_unwatched && speed > kGreatestUnwatchedSpeed_in_per_s) {
      refusals.push_back(
          fmt::format("limits.safe_V = {:g} V, {:.3g} V from the valve's null, moves the rod at {:.2g} in/s if the "
                      "valve has no dead band, and no enable line switches the hydraulics off; set {:g}, the null",
                      rig.limits.safe_V, away_V, speed, null_V));
    }
    if (is_unwatched || speed <= kGreatestSafeSpeed_in_per_s) return;
    refusals.push_back(fmt::format(
        "limits.safe_V = {:g} V, {:.3g} V from the valve's null, moves the rod at {:.2g} in/s whenever the hydraulics "
        "go on; set {:g}, the null",
        rig.limits.safe_V, away_V, speed, null_V));
    return;
  }
  refusals.push_back(
      fmt::format("limits.safe_V = {:g} V drives the valve; set {:g}, within {:.3g} V of the valve's null{}",
                  rig.limits.safe_V, null_V, most_V,
                  hal::switches_hydraulics(rig.backend) ? "" : ", because no enable line switches the hydraulics off"));
}

void judge_limits(const config::RigConfig& rig, std::vector<std::string>& refusals) {
  const config::RigLimits& limits = rig.limits;
  const double travel_in = limits.travel_max_in - limits.travel_min_in;
  const double half_range_V = 0.5 * (limits.command_max_V - limits.command_min_V);
  if (const double most = travel_in / kShortestCrossing_s; limits.velocity_limit_in_per_s > most) {
    refusals.push_back(fmt::format(
        "limits.velocity_limit_in_per_s = {:g} in/s lets the rod cross its whole travel in under {:g} s; set "
        "what the rig needs, at most {:.3g}",
        limits.velocity_limit_in_per_s, kShortestCrossing_s, most));
  }
  if (const double most = 2.0 * half_range_V / kShortestSweep_s; limits.slew_V_per_s > most) {
    refusals.push_back(
        fmt::format("limits.slew_V_per_s = {:g} V/s sweeps the whole command range in under {:g} s; set what the rig "
                    "needs, at most {:.3g}",
                    limits.slew_V_per_s, kShortestSweep_s, most));
  }
  const double farthest_V = std::max(limits.command_max_V - limits.safe_V, limits.safe_V - limits.command_min_V);
  if (const double ramp_s = farthest_V / limits.slew_V_per_s; ramp_s > kLongestRampOut_s) {
    refusals.push_back(
        fmt::format("limits.slew_V_per_s = {:g} V/s: a stop ramps the command out at the slew limit and would take "
                    "{:.3g} s; set at least {:.3g}",
                    limits.slew_V_per_s, ramp_s, farthest_V / kLongestRampOut_s));
  }
  if (limits.stopping_deceleration_in_per_s2 > kGreatestDeceleration_in_per_s2) {
    refusals.push_back(fmt::format(
        "limits.stopping_deceleration_in_per_s2 = {:g} in/s^2 is over ten times gravity, so that no stopping "
        "distance is kept; set what the rig reaches, at most {:g}",
        limits.stopping_deceleration_in_per_s2, kGreatestDeceleration_in_per_s2));
  }
  if (limits.closed_loop_max_V.value_or(0.0) > half_range_V) {
    refusals.push_back(
        fmt::format("limits.closed_loop_max_V = {:g} V is more than half the command range; set at most "
                    "{:g}",
                    *limits.closed_loop_max_V, half_range_V));
  }
  if (limits.following) judge_following(rig, half_range_V, travel_in, refusals);
}

void judge_sensor(const config::RigConfig& rig, ArmingFindings& findings) {
  const config::RigLimits& limits = rig.limits;
  if (!limits.sensor) {
    findings.warnings.emplace_back(
        "no [sensor] in the rig file: an open wire may read as a place within the travel; measure the input with the "
        "wire off and write valid_min_V, valid_max_V and open_circuit_V, see eha-rig(5)");
    return;
  }
  if (!limits.sensor->open_circuit_V) {
    findings.warnings.emplace_back(
        "sensor.open_circuit_V is unknown: an open wire may read as a place within the travel; measure the input with "
        "the wire off");
    return;
  }
  const hal::Conversion conversion = hal::conversion_of(rig.backend);
  const double open_V = *limits.sensor->open_circuit_V;
  const double beyond_V = kReadBeyondRange * (conversion.feedback_max_V - conversion.feedback_min_V);
  if (open_V < conversion.feedback_min_V - beyond_V || open_V > conversion.feedback_max_V + beyond_V) {
    findings.refusals.push_back(fmt::format(
        "sensor.open_circuit_V = {:g} V is no reading of an input of {:g} to {:g} V, so that nothing shows an "
        "open wire; measure the input with the wire off and write what `eha read` shows",
        open_V, conversion.feedback_min_V, conversion.feedback_max_V));
  }
  const double place_in = conversion.offset_in + conversion.scale_in_per_V * open_V;
  if (place_in >= limits.travel_min_in && place_in <= limits.travel_max_in) {
    findings.refusals.push_back(fmt::format(
        "sensor.open_circuit_V = {:g} V reads as {:.3f} in, within the travel {:g}..{:g} in: an open wire "
        "looks like a rod at rest; bias the input to a rail (1 Mohm to the card's +12 V), measure the input "
        "with the wire off again and write that value",
        open_V, place_in, limits.travel_min_in, limits.travel_max_in));
  }
}

/// Warns of a travel in which hardly any rod moves: of a rig file with inches for millimetres.
void judge_travel(const config::RigConfig& rig, std::vector<std::string>& warnings) {
  const config::RigLimits& limits = rig.limits;
  const hal::Conversion sensor = hal::conversion_of(rig.backend);
  const double travel_in = limits.travel_max_in - limits.travel_min_in;
  const double shown_in = std::abs(sensor.scale_in_per_V * (sensor.feedback_max_V - sensor.feedback_min_V));
  if (travel_in < kLeastTravelShare * shown_in) {
    warnings.push_back(
        fmt::format("limits.travel_min_in..travel_max_in = {:g}..{:g} in, {:.2g} % of the {:.3g} in ({:.3g} mm) that "
                    "the sensor can show: inches for millimetres? Set the travel of the rig",
                    limits.travel_min_in, limits.travel_max_in, 100.0 * travel_in / shown_in, shown_in,
                    kMillimetresPerInch * shown_in));
  } else if (const double travel_mm = kMillimetresPerInch * travel_in; travel_mm < kLeastTravel_mm) {
    warnings.push_back(fmt::format(
        "limits.travel_min_in..travel_max_in = {:g}..{:g} in, a travel of {:.2g} mm: are limits and sensor of "
        "the rig file in another unit than their keys? A rod that goes further than it reads is too fast "
        "for every limit",
        limits.travel_min_in, limits.travel_max_in, travel_mm));
  }
}

void judge_sample(const config::RigConfig& rig, std::vector<std::string>& refusals) {
  if (!rig.is_sample) return;
  refusals.push_back(
      "sample = true: this file is an example, its wiring, calibration and limits are of no rig; copy it to "
      "/etc/ehad, set what your rig has and remove this line");
}

std::string named(const hal::Rig& rig) {
  const std::string& device = rig.capabilities().device;
  return device.empty() ? "the rig" : device;
}

}  // namespace

ArmingFindings arming_findings(const config::RigConfig& rig) {
  ArmingFindings findings;
  judge_travel(rig, findings.warnings);
  if (const std::string valve = unreachable_valve(rig.limits); !valve.empty()) {
    (hal::moves_machine(rig.backend) ? findings.refusals : findings.warnings).push_back(valve);
  }
  if (!hal::moves_machine(rig.backend)) {
    if (const char* changed = rig.limits.following ? changed_since_measured(rig) : nullptr) {
      findings.warnings.push_back(fmt::format("{}; a rig that moves a machine would not be armed", changed));
    }
    return findings;
  }
  judge_sample(rig, findings.refusals);
  judge_safe_V(rig, findings.refusals);
  judge_limits(rig, findings.refusals);
  judge_realtime(rig, findings);
  judge_sensor(rig, findings);
  if (config::needs_following(rig)) findings.warnings.emplace_back(config::kNeedsFollowing);
  return findings;
}

std::unique_ptr<hal::Rig> open_at_rest(const config::RigConfig& rig) {
  if (hal::moves_machine(rig.backend) && !hal::switches_hydraulics(rig.backend)) {
    std::vector<std::string> lines;
    judge_sample(rig, lines);
    judge_safe_V(rig, lines);
    if (rig.limits.following && !config::is_as_measured(rig)) judge_null(*rig.limits.following, lines);
    for (std::string& line : lines) line = fmt::format("{}: not opened: {}", rig.file_name, line);
    if (!lines.empty()) throw ConfigError(lines);
  }
  if (hal::powers_when_off(rig.backend)) {
    throw ConfigError(fmt::format(
        "{}: not opened: [comedi.enable] active = \"low\" powers the hydraulics while the computer is off or boots, as "
        "outputs are low then, and a slip here would switch them on at rest: wire it so that \"high\" powers them, or "
        "give the contactor's auxiliary contact, [comedi.enable_contact]",
        rig.file_name));
  }
  return hal::open(rig.backend, rig.limits.safe_V);
}

std::string rest_text(const config::RigConfig& rig) {
  return fmt::format("at {} V {}", rig.limits.safe_V,
                     hal::switches_hydraulics(rig.backend) ? "with the hydraulics off"
                                                           : "without an enable line: the hydraulics stay on");
}

void require_protecting_limits(const config::RigConfig& rig) {
  std::vector<std::string> lines = arming_findings(rig).refusals;
  if (lines.empty()) return;
  for (std::string& line : lines) line = fmt::format("{}: not armed: {}", rig.file_name, line);
  throw ConfigError(lines);
}

void require_plausible_inputs(hal::Rig& rig, const config::RigConfig& config) {
  const acquisition::FollowingRule rule = acquisition::following_rule(config.limits);
  const auto pause =
      std::chrono::nanoseconds(std::llround(std::max(kReadingPeriod_s, config.realtime.sample_period_s) * 1e9));
  double lowest_in = std::numeric_limits<double>::infinity();
  double highest_in = -lowest_in;
  double bends_in2 = 0.0;  // squares of second differences, in which a rod that sinks slowly is not seen
  double before_in[2] = {0.0, 0.0};
  for (int i = 0; i < kReadings; ++i) {
    if (i > 0) std::this_thread::sleep_for(pause);
    hal::RigReading reading;
    const hal::RigStatus status = rig.read(0, reading);
    if (status != hal::RigStatus::ok) {
      throw DeviceError(fmt::format("not armed: {} cannot be read ({}); eha doctor says more", named(rig),
                                    acquisition::to_text(status)));
    }
    if (reading.emergency_stop) {
      throw Error(ExitCode::safety_trip, "not armed: the emergency-stop circuit is open; close it, then eha arm");
    }
    if (reading.enable_contact) {
      throw Error(ExitCode::safety_trip,
                  fmt::format("not armed: {}", acquisition::sentence_of(acquisition::CircuitAtRest::contact)));
    }
    const auto& band = config.limits.sensor;
    const bool outside = band && (reading.feedback_V < band->valid_min_V || reading.feedback_V > band->valid_max_V);
    if (reading.feedback_at_rail || outside || !std::isfinite(reading.displacement_in)) {
      throw Error(
          ExitCode::safety_trip,
          fmt::format("not armed: the displacement sensor gives {:.3f} V, {}; check the sensor and its cable",
                      reading.feedback_V,
                      outside ? fmt::format("outside its valid band {:g}..{:g} V", band->valid_min_V, band->valid_max_V)
                              : "the end of the converter's range"));
    }
    lowest_in = std::min(lowest_in, reading.displacement_in);
    highest_in = std::max(highest_in, reading.displacement_in);
    if (i >= 2) bends_in2 += std::pow(reading.displacement_in - 2.0 * before_in[1] + before_in[0], 2);
    before_in[0] = std::exchange(before_in[1], reading.displacement_in);
  }
  // The following check sums differences, in which noise telescopes: this much noise uses at most half of its limit.
  const double most_in = 0.5 * std::min(rule.missing_limit_in, rule.excess_limit_in);
  const DisplayUnit unit(config.units);
  const double factor = unit.factor("in");
  if (highest_in - lowest_in > most_in) {
    throw Error(ExitCode::safety_trip,
                fmt::format("not armed: with the hydraulics off the sensor's reading varies by {0:.4f} {2}, at most "
                            "{1:.4f} {2} is plausible; check that the load does not sink, and the sensor, its cable "
                            "and its shield",
                            factor * (highest_in - lowest_in), factor * most_in, unit.of("in")));
  }
  // The checks of a placing average as many readings as their time holds. Numbers that nobody measured on this rig may
  // move it faster than they say, and need a dead sensor to be found earlier.
  const double noise_in = std::sqrt(bends_in2 / (6.0 * (kReadings - 2)));
  const double longer = std::max(1.0, config.realtime.sample_period_s / kShortTick_s);
  const double range_in = config::is_as_measured(config) ? std::min(most_in, kRangeOfMeasured_in)
                                                         : std::min(0.5 * most_in, kRangeOfUnmeasured_in);
  const double most_noise_in = range_in / (kSpread * std::sqrt(longer));
  if (noise_in > most_noise_in) {
    throw Error(
        ExitCode::safety_trip,
        fmt::format(
            "not armed: the sensor's noise of {0:.4f} {4} (standard deviation) hides a dead sensor for too "
            "long at ticks of {1:g} ms; at most {2:.4f} {4} is taken{3}: check the sensor, its cable and its shield, "
            "or take a shorter sample_period_s",
            factor * noise_in, 1e3 * config.realtime.sample_period_s, factor * most_noise_in,
            config::is_as_measured(config) ? "" : " while [following] is not as it was measured here", unit.of("in")));
  }
}

}  // namespace eha
