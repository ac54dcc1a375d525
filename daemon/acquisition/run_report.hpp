// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/display_unit.hpp"
#include "core/enum_names.hpp"
#include "core/error.hpp"
#include "daemon/acquisition/histogram.hpp"
#include "daemon/acquisition/status_board.hpp"
#include "daemon/acquisition/tick_record.hpp"
#include "hal/rig.hpp"

namespace eha::acquisition {

/// Outcome of a run. Only a run that is_whole() is fitted automatically.
enum class Outcome : std::uint8_t {
  completed,
  precise_enough,  ///< ended early after a repetition, by a condition of its experiment
  interrupted,
  faulted,
  deadline,
  write_failed,
  recovered
};
inline constexpr EnumNames<Outcome, 7> kOutcomes{{{"completed", Outcome::completed},
                                                  {"precise_enough", Outcome::precise_enough},
                                                  {"interrupted", Outcome::interrupted},
                                                  {"faulted", Outcome::faulted},
                                                  {"deadline", Outcome::deadline},
                                                  {"write_failed", Outcome::write_failed},
                                                  {"recovered", Outcome::recovered}}};

/// Whether a run played all that it should.
[[nodiscard]] constexpr bool is_whole(Outcome outcome) noexcept {
  return outcome == Outcome::completed || outcome == Outcome::precise_enough;
}

/// The same for the outcome of a name; false for an unknown name.
[[nodiscard]] constexpr bool is_whole(std::string_view outcome) noexcept {
  const std::optional<Outcome> known = value_in(kOutcomes, outcome);
  return known && is_whole(*known);
}

/// The first fault of a run.
struct FaultReport {
  Fault fault = Fault::none;
  hal::RigStatus status = hal::RigStatus::ok;  ///< of the call that failed, when one did
  std::int64_t at_ns = 0;                      ///< from the run's first tick [ns]
  double value = 0.0;                          ///< measured, in the unit of the limit
  double limit = 0.0;                          ///< allowed
  bool has_jumped = false;                     ///< by then the reading had left the rod's place, whatever ended the run
  double driven_V = 0.0;                       ///< of no_motion: as of Breach
  double driven_s = 0.0;                       ///< of no_motion; 0: not known
};

/// Closest approach of a run to a limit of the rig.
struct Margin {
  double share = 0.0;      ///< of the limit; over 1 where it tripped
  std::int64_t at_ns = 0;  ///< when, from the run's first tick [ns]
};

/// Real-time privileges that the operating system granted the loop.
struct RealtimeFacts {
  bool fifo = false;                 ///< SCHED_FIFO at the asked priority
  bool memory_locked = false;        ///< mlockall
  bool cpu_bound = false;            ///< bound to the asked CPU
  bool c_states_held = false;        ///< /dev/cpu_dma_latency held at 0
  std::vector<std::string> refused;  ///< one sentence for each thing not granted, with its cause and remedy
};

/// Report of one run of the loop.
struct RunReport {
  Outcome outcome = Outcome::completed;
  State final_state = State::faulted;
  FaultReport fault;
  bool safe_confirmed = false;  ///< the device acknowledged the safe voltage and the enable off
  std::uint32_t stops_seen = 0;
  LoopCounters counters;
  /// First row of the experiment, at which the time of its record is 0, from the run's first tick [ns]; 0: never
  /// reached.
  std::int64_t experiment_ns = 0;
  Margin travel;          ///< on the way from mid-travel to a travel limit, stopping distance included
  Margin velocity;        ///< of the velocity limit
  double moved_in = 0.0;  ///< the greatest reading less the least [in]
  Histogram latency;      ///< wake-up lateness
  Histogram execution;    ///< duration of a tick's work
  RealtimeFacts realtime;
};

/// A time of a report as the record of the run counts it [s]: from the first row of the experiment, the ramp before
/// being negative; from the run's first tick if that row was never reached.
[[nodiscard]] inline double record_s(const RunReport& report, std::int64_t at_ns) noexcept {
  return static_cast<double>(at_ns - report.experiment_ns) * kSecondsPerNanosecond;
}

/// "completed", "write_failed", ...
[[nodiscard]] std::string_view to_text(Outcome outcome) noexcept;

/// Returns the exit code of a program that runs one experiment, before any model is judged.
[[nodiscard]] ExitCode exit_code(const RunReport& report) noexcept;

/// Whether a run ended because its sensor's reading jumped as no rod moves, so that the rod may stand elsewhere than
/// shown: sensor_slip, or velocity_limit over three times faster than any rod.
[[nodiscard]] bool reading_jumped(const FaultReport& report) noexcept;

/// Of a description: the readings moved as no rod does.
inline constexpr std::string_view kReadingJumps = "its reading jumps";
/// Before this time of a run no command has moved the rod.
inline constexpr std::int64_t kBegun_ns = 20'000'000;
/// What to do once the reading has jumped.
inline constexpr std::string_view kCompareWithRuler =
    "hold a ruler to the rod and compare it with `eha read` before anything moves; `eha arm --ruler LENGTH` arms where "
    "they agree, else `eha calibrate --sensor-moved`";
/// The last cause of no_motion, which is none of a rig file without [following].
inline constexpr std::string_view kWrongNull =
    "; if all is sound, null or dead band of [following], where the file has it, is wrong: `eha characterise` measures "
    "both; where that is what tripped: `eha characterise --without-following -o rig-bare.toml`, and its Next";

// What a description may end with, behind "; ", whatever the fault.
inline constexpr std::string_view kRecordsLost = " records were lost because the writer was too slow";
inline constexpr std::string_view kOutputNotSafe =
    "THE OUTPUT IS NOT CONFIRMED SAFE: switch the hydraulics off by hand";

inline constexpr std::string_view kGuardDied = "the guard of the rig has died";

/// Describes the end of a run in one or more sentences: what, when, value, limit, next step. Empty if it completed.
/// @param unit  of lengths; by default in, as the rig's limits
[[nodiscard]] std::string describe(const RunReport& report, const DisplayUnit& unit = {});

/// Purpose of a run.
enum class RunKind { experiment, placing };

/// Returns a sentence on late or skipped ticks, and one for each limit that the run used by more than kWarningShare
/// without being ended by it.
/// @param kind  for a placing the limits are left out: the user chose its place, and a way back begins beyond a limit
[[nodiscard]] std::vector<std::string> warnings(const RunReport& report, RunKind kind = RunKind::experiment);

}  // namespace eha::acquisition
