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

/// How a run ended. Only a run that is_whole() is fitted without being asked.
enum class Outcome : std::uint8_t {
  completed,
  precise_enough,  ///< early, after a repetition, as its experiment wants it
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

/// Whether a run played what it was to play.
[[nodiscard]] constexpr bool is_whole(Outcome outcome) noexcept {
  return outcome == Outcome::completed || outcome == Outcome::precise_enough;
}

/// The same of a name; false for one that is none.
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
};

/// The closest that a run came to a limit of the rig.
struct Margin {
  double share = 0.0;      ///< of the limit; over 1 where it tripped
  std::int64_t at_ns = 0;  ///< when, from the run's first tick [ns]
};

/// What the operating system granted the loop.
struct RealtimeFacts {
  bool fifo = false;                 ///< SCHED_FIFO at the asked priority
  bool memory_locked = false;        ///< mlockall
  bool cpu_bound = false;            ///< bound to the asked CPU
  bool c_states_held = false;        ///< /dev/cpu_dma_latency held at 0
  std::vector<std::string> refused;  ///< one sentence for each thing not granted, with its cause and remedy
};

/// How one run of the loop went.
struct RunReport {
  Outcome outcome = Outcome::completed;
  State final_state = State::faulted;
  FaultReport fault;
  bool safe_confirmed = false;  ///< the device acknowledged the safe voltage and the enable off
  std::uint32_t stops_seen = 0;
  LoopCounters counters;
  Margin travel;        ///< on the way from mid-travel to a travel limit, stopping distance included
  Margin velocity;      ///< of the velocity limit
  Histogram latency;    ///< wake-up lateness
  Histogram execution;  ///< duration of a tick's work
  RealtimeFacts realtime;
};

/// "completed", "write_failed", ...
[[nodiscard]] std::string_view to_text(Outcome outcome) noexcept;

/// Exit code of a program that runs one experiment, before any model is judged.
[[nodiscard]] ExitCode exit_code(const RunReport& report) noexcept;

/// One or more sentences on how the run ended: what, when, value, limit, next step. Empty when it completed.
/// @param unit  of lengths; as the rig's limits, in, by default
[[nodiscard]] std::string describe(const RunReport& report, const DisplayUnit& unit = {});

/// What a run does with the rod.
enum class RunKind { experiment, placing };

/// A sentence on ticks that were late or skipped, and one for each limit of which the run used over kWarningShare and
/// that did not end it.
/// @param kind  of a placing the limits are left out: its place was asked for, and a way back begins beyond one
[[nodiscard]] std::vector<std::string> warnings(const RunReport& report, RunKind kind = RunKind::experiment);

}  // namespace eha::acquisition
