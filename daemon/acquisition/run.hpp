// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/rig_config.hpp"
#include "core/error.hpp"
#include "daemon/acquisition/clock.hpp"
#include "daemon/acquisition/histogram.hpp"
#include "daemon/acquisition/record_queue.hpp"
#include "daemon/acquisition/state_machine.hpp"
#include "daemon/acquisition/status_board.hpp"
#include "daemon/acquisition/stop_request.hpp"
#include "hal/rig.hpp"

namespace eha::acquisition {

/// What is played on the valve.
struct Excitation {
  std::span<const double> table_V;  ///< one repetition, one voltage a tick [V]; not empty
  std::uint32_t repetitions = 1;    ///< 1..65535, played back to back
};

/// How a run ended. Only `completed` runs are fitted without being asked.
enum class Outcome : std::uint8_t { completed, interrupted, faulted, deadline, write_failed, recovered };

/// Whether a loop without real-time privileges may run.
enum class NonRealtime : std::uint8_t {
  refuse,  ///< PermissionError, unless the rig moves no machine (RigCapabilities::moves_machine)
  allow,   ///< run on ordinary scheduling and say so
};

/// What the first fault of a run was.
struct FaultReport {
  Fault fault = Fault::none;
  hal::RigStatus status = hal::RigStatus::ok;  ///< of the call that failed, when one did
  std::int64_t at_ns = 0;                      ///< from the run's first tick [ns]
  double value = 0.0;                          ///< what was seen, in the unit of the limit
  double limit = 0.0;                          ///< what is allowed
};

/// What the operating system granted the loop.
struct RealtimeFacts {
  bool fifo = false;                 ///< SCHED_FIFO at the asked priority
  bool memory_locked = false;        ///< mlockall
  bool cpu_bound = false;            ///< bound to the asked CPU
  bool c_states_held = false;        ///< /dev/cpu_dma_latency held at 0
  std::vector<std::string> refused;  ///< one sentence for each thing not granted, with its cause and remedy
};

/// All there is to say about one run of the loop.
struct RunReport {
  Outcome outcome = Outcome::completed;
  State final_state = State::faulted;
  FaultReport fault;
  bool safe_confirmed = false;  ///< the device acknowledged the safe voltage and the enable off
  std::uint32_t stops_seen = 0;
  LoopCounters counters;
  Histogram latency;    ///< wake-up lateness
  Histogram execution;  ///< duration of a tick's work
  RealtimeFacts realtime;
};

/// Plays an excitation on a rig, one tick each sample period, and blocks until the rig is idle or faulted again. On the
/// monotonic clock the loop gets a thread of its own (SCHED_FIFO, memory locked); on a virtual one it runs in the
/// caller's and waits for the writer. The queue must be drained by another thread at the same time.
/// The row whose state first is `running` applies table_V[0]; before it the command ramps there from the safe voltage
/// under the slew limit, after the last row it ramps back. Late ticks end a run on a rig that moves; on one that moves
/// nothing they are only counted, except in virtual time, where they can only be injected. See tick_engine.hpp for what
/// a tick does.
/// @param machine  must be armed; is idle afterwards, or faulted
/// @throws ConfigError      limits that contradict each other or the rig, an empty table; nothing was written
/// @throws PermissionError  the privileges are missing and NonRealtime::refuse; nothing was written
[[nodiscard]] RunReport run(hal::Rig& rig, StateMachine& machine, const Excitation& excitation,
                            const config::RigLimits& limits, const config::RealtimeOptions& realtime,
                            NonRealtime non_realtime, Clock& clock, RecordQueue& queue, const StopRequest& stop,
                            StatusBoard& board);

/// "completed", "write_failed", ...
[[nodiscard]] std::string_view to_text(Outcome outcome) noexcept;

/// The exit code that a program running one experiment ends with, before any model is judged.
[[nodiscard]] ExitCode exit_code(const RunReport& report) noexcept;

/// One or more sentences on how the run ended: what, when, value, limit, next step. Empty when it completed.
[[nodiscard]] std::string describe(const RunReport& report);

}  // namespace eha::acquisition
