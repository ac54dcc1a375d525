// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/run_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace eha::acquisition {
namespace {

/// Writes a value with at least three decimals, and as many as distinguish it from another.
std::string told_apart(double value, double other) {
  constexpr int kFewest = 3;
  constexpr int kMost = 6;
  int digits = kFewest;
  while (digits < kMost && fmt::format("{:.{}f}", value, digits) == fmt::format("{:.{}f}", other, digits)) ++digits;
  return fmt::format("{:.{}f}", value, digits);
}

constexpr double kNoRod = 3.0;  // times the velocity limit: a reading that jumps

/// Motion below it is of a sensor's noise and resolution.
constexpr double kNoMotion_in = 0.0005;
constexpr double kNothing_in = 0.0001;      // is shown as 0
constexpr double kMostTrembling_in = 0.02;  // of a reading that stands still

constexpr const char* kAnew =
    "`eha characterise --without-following -o rig-bare.toml` and its Next measure [following] anew";

/// A closed loop drove the rod, which did not move as it must: value is what it moved towards the command, limit what
/// was due [in].
std::string describe_no_motion(const FaultReport& fault, const DisplayUnit& unit) {
  const double moved_in = fault.value;
  const double due_in = fault.limit;
  const std::string drove = fault.driven_s > 0.0
                                ? fmt::format("a closed loop drove the rod for {:.2g} s, at last with {:+.2f} V",
                                              fault.driven_s, fault.driven_V)
                                : "a closed loop drove the rod";
  const double factor = unit.factor("in");
  const std::string length = unit.of("in");
  if (moved_in > std::max(due_in, kNoMotion_in)) {
    return fmt::format(
        "{4}, and the sensor shows {0:.2g} {2} of motion where {1:.2g} {2} were due: not the "
        "motion of its volts; likely, in this order: the sensor or its wire is loose, so that the reading jumps, a "
        "load moves the rod: see that `eha read` follows the rod and stands while it stands; if it does, {3}",
        factor * moved_in, factor * due_in, length, kAnew, drove);
  }
  // Noise of a reading that stands still does not go back further than the way that was due.
  if (moved_in < -std::clamp(due_in, kNoMotion_in, kMostTrembling_in)) {
    const std::string shown =
        due_in < kNoMotion_in ? fmt::format("{:.2g} {} of motion while no motion was due", -factor * moved_in, length)
                              : fmt::format("{:.2g} {} the other way where {:.2g} {} were due", -factor * moved_in,
                                            length, factor * due_in, length);
    return fmt::format(
        "{}, and the sensor shows {}; likely, in this order: the null of [following] in the "
        "rig file is wrong, the sign of valve or sensor is, the sensor's wire is open: see that `eha read` follows the "
        "rod; if it does, {}",
        drove, shown, kAnew);
  }
  return fmt::format(
      "{4}, and it moved {0:.2g} {2} where {1:.2g} {2} were due; look, in this order: "
      "hydraulics on and under pressure, valve plugged in, rod off its end stops, sensor on (`eha read` follows the "
      "rod), oil past the piston{3}",
      moved_in < kNothing_in ? 0.0 : factor * moved_in, factor * due_in, length, kWrongNull, drove);
}

std::string describe_fault(const RunReport& run, const DisplayUnit& unit) {
  const FaultReport& report = run.fault;
  const double value = report.value;
  const double limit = report.limit;
  const std::string length = unit.of("in");
  const double shown_value = unit.factor("in") * value;
  const double shown_limit = unit.factor("in") * limit;
  const std::string_view status = to_text(report.status);
  switch (report.fault) {
    case Fault::none:
      return {};
    case Fault::emergency_stop:
      return "the emergency-stop circuit is open; close it and arm again";
    case Fault::travel_limit:
      return fmt::format(
          "the rod is at, or would not stop before, {0} {2}, the limit is {1} {2}; {3}",
          told_apart(shown_value, shown_limit), told_apart(shown_limit, shown_value), length,
          report.at_ns < kBegun_ns
              ? "it stood there when the run began: if you see it stand there, `eha goto` brings it "
                "inward, and asks first; else correct calibration or limits in the rig file"
              : "start nearer to mid-travel, correct offset_V where the rod drifted, or lower the excitation");
    case Fault::velocity_limit:
      // Steps of the reading before do not make the speed of a rod.
      if (std::abs(value) > kNoRod * std::abs(limit)) {
        return fmt::format(
            "the sensor shows {0:.2f} {2}/s, as no rod moves whose limit is {1:.2f} {2}/s: {3}; look at its supply, "
            "cable, shield and earth (`eha read` shows its noise), or put a low-pass filter of some 100 Hz before the "
            "card's input",
            shown_value, shown_limit, length, kReadingJumps);
      }
      return fmt::format(
          "the rod moved at {0:.2f} {2}/s, the limit is {1:.2f} {2}/s; lower the excitation, or "
          "check the sensor if the rod did not",
          shown_value, shown_limit, length);
    case Fault::feedback_rail:
      return fmt::format(
          "the displacement converter is at the end of its range ({:.3f} V); check the sensor, its cable and range",
          value);
    case Fault::frozen_sensor:
      return fmt::format(
          "the displacement code did not change for {:.3f} s although the valve was driven, the limit is {:.3f} s; "
          "check the sensor and the hydraulic supply",
          value, limit);
    case Fault::feedback_not_finite:
      return "the displacement is not a number; check the calibration in the rig file";
    case Fault::command_not_finite:
      return "a voltage that is not a number was to be written; this is a bug";
    case Fault::repeated_timeouts:
      return fmt::format(
          "the card timed out in {:.0f} ticks in a row, {:.0f} are tolerated; check the card and its driver", value,
          limit);
    case Fault::call_overran:
      return fmt::format(
          "a failed call on the card ({}) took {:.4f} s, a tick is {:.4f} s; check the card and its driver", status,
          value, limit);
    case Fault::read_failed:
      return fmt::format("the card refused a read ({}); check the card and its driver", status);
    case Fault::command_failed:
      return fmt::format("the card refused a write ({}); check the card and its driver", status);
    case Fault::device_removed:
      return "the device is gone; check the card and its driver";
    case Fault::consecutive_late:
      return fmt::format(
          "{:.0f} ticks in a row were late or skipped, the limit is {:.0f} (abort_consecutive_late in [realtime] of "
          "the rig file); what was recorded until then is kept; `eha doctor` and `eha latency` say what keeps the "
          "computer busy: mend that before you raise the limit",
          value, limit);
    case Fault::total_late:
      return fmt::format(
          "{:.0f} ticks were late or skipped, the limit is {:.0f} (abort_total_late in [realtime] of the rig "
          "file, one is forgiven each second); what was recorded until then is kept; `eha doctor` and `eha latency` "
          "say what keeps the computer busy: mend that before you raise the limit",
          value, limit);
    case Fault::second_stop:
      return "stopped at once by a second stop request; a person wanted it, and the state is faulted because the rig "
             "was made safe without a ramp";
    case Fault::safe_write_failed:
      return fmt::format("the device did not confirm the safe output at the end of the run ({})", status);
    case Fault::not_following:
      return fmt::format(
          "the rod moved {0:.3f} {2} less than the command must have moved it, the limit is {1:.3f} {2}; likely, in "
          "this order: hydraulics off, valve unplugged, sensor or its wire off, a leak, [following] of the rig file, "
          "where it has one, out of date: switch on, plug in, see that `eha read` follows the rod",
          shown_value, shown_limit, length);
    case Fault::unexplained_motion:
      return fmt::format(
          "the sensor shows {0:.3f} {2} of motion that the command cannot have made, the limit is {1:.3f} {2}: the "
          "wrong way, by sign or wiring of sensor or valve, or farther than [following] of the rig file has it, by "
          "more flow or a load; `eha plot` of the run shows which",
          shown_value, shown_limit, length);
    case Fault::enable_contact:
      return fmt::format(
          "the auxiliary contact of the enable contactor stayed open for {:.3f} s with the enable line on, {:.3f} s "
          "are allowed; check the contactor, its contact and the hydraulics' supply",
          value, limit);
    case Fault::feedback_band:
      return fmt::format(
          "the displacement sensor gives {:.3f} V, beyond the {:.3f} V of a sound one; check the sensor and its cable",
          value, limit);
    case Fault::no_motion:
      return describe_no_motion(report, unit);
    case Fault::not_in_place:
      if (value < limit) {
        return fmt::format(
            "the rod was {0:.3f} {1} from its place at the time-out, near enough, but did not rest: {2}, or rod and "
            "valve swing; look at the sensor's supply, cable, shield and earth (`eha read` shows its noise)",
            shown_value, length, kReadingJumps);
      }
      return fmt::format(
          "the rod was still {0:.3f} {2} from its place at the time-out, {1:.3f} {2} are allowed; look at [following] "
          "in the rig file",
          shown_value, shown_limit, length);
    case Fault::loop_speed:
      return fmt::format(
          "a closed loop moved the rod at {0:.2f} {2}/s, {1:.2f} {2}/s are allowed; check gains, null and dead band of "
          "[following] in the rig file, and the calibration of the sensor",
          shown_value, shown_limit, length);
    case Fault::wrong_speed:
      return fmt::format(
          "the sensor showed {0:.3f} {3}/s, the volts give {1} {2:.3f} {3}/s by [following]; check the "
          "sensor, its wire and its calibration{4}",
          shown_value, value < limit ? "at least" : "at most", shown_limit, length,
          value < limit ? ", the supply pressure, then [following] in the rig file; a leak of cylinder or valve, or a "
                          "load, slows it as well (the valve sheet shows a leak)"
                        : ", then [following] in the rig file");
    case Fault::following_error:
      return fmt::format(
          "the rod was {0:.4g} {2} from its reference, the controller's file allows {1:.4g} {2}; {3}", shown_value,
          shown_limit, length,
          report.at_ns - run.experiment_ns < kBegun_ns
              ? fmt::format("no valve moves a rod so far in so short a time, the sensor is wrong, {}; look at its "
                            "supply, cable, shield and earth (`eha read` shows its noise)",
                            kReadingJumps)
              : "likely, in this order: the supply pressure or the valve has changed (`eha characterise`, then `eha "
                "tune`), the load, the sensor");
    case Fault::oscillation:
      return fmt::format(
          "the command swung {:.0f} times in a second, {:.0f} are allowed by the controller's file; likely, in this "
          "order: "
          "the valve has changed (`eha characterise`, then `eha tune`), the load",
          value, limit);
    case Fault::loop_stalled:
      return fmt::format(
          "the loop stood still for {:.3f} s, and the guard switched the hydraulics off; look for a process of a "
          "higher real-time priority or a host that takes the processor away: eha doctor and eha latency",
          value);
    case Fault::suspended:
      return fmt::format(
          "the machine was suspended for {:.3g} s, and the output held its voltage meanwhile: look where the rod is "
          "(`eha read`); to forbid suspends: `systemctl mask sleep.target`",
          value);
    case Fault::sensor_slip:
      return fmt::format(
          "the sensor's reading jumped by {0:+.3f} {2} in all, as no rod moves, {1:.3f} {2} are allowed: its coupling "
          "or holder slips, or its track or plug is worn, and the rod may stand that far from the reading; mend that, "
          "{3}",
          shown_value, std::abs(shown_limit), length, kCompareWithRuler);
    case Fault::wrong_place:
      return fmt::format(
          "by its volts the rod may be {0:+.2f} {2} from where its sensor shows it, and so at its travel limit of "
          "{1:.3f} {2}; look where it stands; likely, in this order: the sensor's slope has changed, it drifts or "
          "slips (`eha calibrate`); a load, the supply pressure or the valve makes the rod over 12 % slower than "
          "[following] has it (`eha characterise`)",
          shown_value, shown_limit, length);
  }
  return "unknown fault";
}

bool is_of_the_device(Fault fault) {
  switch (fault) {
    case Fault::repeated_timeouts:
    case Fault::call_overran:
    case Fault::read_failed:
    case Fault::command_failed:
    case Fault::device_removed:
    case Fault::safe_write_failed:
      return true;
    default:
      return false;
  }
}

}  // namespace

std::string_view to_text(Outcome outcome) noexcept { return name_in(kOutcomes, outcome); }

ExitCode exit_code(const RunReport& report) noexcept {
  switch (report.outcome) {
    case Outcome::completed:
    case Outcome::precise_enough:
    case Outcome::recovered:
      return ExitCode::ok;
    case Outcome::interrupted:
      // The person who stopped it relies on a safe output now.
      return report.safe_confirmed ? ExitCode::interrupted : ExitCode::device_unavailable;
    case Outcome::faulted:
      return is_of_the_device(report.fault.fault) ? ExitCode::device_unavailable : ExitCode::safety_trip;
    case Outcome::deadline:
      return ExitCode::deadline;
    case Outcome::write_failed:
      return ExitCode::io;
  }
  return ExitCode::bug;
}

bool reading_jumped(const FaultReport& report) noexcept {
  return report.fault == Fault::sensor_slip || report.has_jumped ||
         (report.fault == Fault::velocity_limit && std::abs(report.value) > kNoRod * std::abs(report.limit));
}

std::vector<std::string> warnings(const RunReport& report, RunKind kind) {
  std::vector<std::string> sentences;
  const LoopCounters& counted = report.counters;
  if (counted.skipped > 0 || counted.late > 0) {
    sentences.push_back(fmt::format(
        "of {} ticks {} began late, at most {:.0f} us, and {} never ran (rows without a reading); eha latency "
        "and eha doctor say what holds the loop up",
        counted.ticks + counted.skipped, counted.late, static_cast<double>(report.latency.maximum_ns()) * 1e-3,
        counted.skipped));
  }
  if (kind == RunKind::placing) return sentences;
  const auto add = [&](const Margin& margin, Fault trip, const char* limit, const char* remedy) {
    if (margin.share <= kWarningShare || report.fault.fault == trip) return;
    sentences.push_back(fmt::format("the run came to {:.0f} % of {} at {:.3f} s, 100 % stops it; {}",
                                    100.0 * margin.share, limit, record_s(report, margin.at_ns), remedy));
  };
  add(report.travel, Fault::travel_limit, "the way to a travel limit, stopping distance included",
      "start nearer to mid-travel, correct offset_V where the rod drifts, or lower the excitation");
  add(report.velocity, Fault::velocity_limit, "the velocity limit", "lower the excitation");
  return sentences;
}

std::string describe(const RunReport& report, const DisplayUnit& unit) {
  std::string text;
  if (report.fault.fault != Fault::none) {
    text = fmt::format("{} at {:.3f} s: {}", to_text(report.fault.fault), record_s(report, report.fault.at_ns),
                       describe_fault(report, unit));
  } else if (report.outcome == Outcome::interrupted) {
    text = "interrupted by a stop request; the command was ramped out";
  } else if (report.outcome == Outcome::write_failed) {
    text = "the record could not be kept; the command was ramped out";
  }
  if (report.counters.dropped > 0) {
    text += fmt::format("{}{}{}", text.empty() ? "" : "; ", report.counters.dropped, kRecordsLost);
  }
  if (!report.safe_confirmed) {
    text += fmt::format("{}{}", text.empty() ? "" : "; ", kOutputNotSafe);
  }
  return text;
}

}  // namespace eha::acquisition
