// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "config/rig_config.hpp"
#include "core/guard_page.hpp"
#include "daemon/acquisition/clock.hpp"
#include "daemon/acquisition/command_source.hpp"
#include "daemon/acquisition/earlier_runs.hpp"
#include "daemon/acquisition/record_queue.hpp"
#include "daemon/acquisition/run_report.hpp"
#include "daemon/acquisition/state_machine.hpp"
#include "daemon/acquisition/status_board.hpp"
#include "daemon/acquisition/stop_request.hpp"
#include "hal/rig.hpp"

namespace eha::acquisition {

/// Whether a loop without real-time privileges may run.
enum class NonRealtime : std::uint8_t {
  refuse,  ///< PermissionError, unless the rig moves no machine (RigCapabilities::moves_machine)
  allow,   ///< run with ordinary scheduling and report it
};

/// Plays the volts of a command source on a rig, one tick each sample period, and blocks until the rig is idle or
/// faulted again. On the monotonic clock the loop gets a thread of its own (SCHED_FIFO, memory locked); on a virtual
/// one it runs in the caller's and waits for the writer. The queue must be drained by another thread at the same time.
/// The first row in state `running` applies the source's row 0. Before it the command ramps there from the safe voltage
/// under the slew limit; after the last row it ramps back. Late ticks end a run on a rig that moves a machine; on
/// others they are only counted, except in virtual time, where they can only be injected. See tick_engine.hpp for what
/// a tick does.
/// @param machine  must be armed; is idle afterwards, or faulted
/// @param page     shared with the rig's guard; none: there is no guard
/// @param earlier  the runs before on this rig, then this one, too; none: this is the only run
/// @throws ConfigError      limits that contradict each other or the rig, a source without rows; nothing was written
/// @throws PermissionError  the privileges are missing and NonRealtime::refuse; nothing was written
[[nodiscard]] RunReport run(hal::Rig& rig, StateMachine& machine, CommandSource& source,
                            const config::RigLimits& limits, const config::RealtimeOptions& realtime,
                            NonRealtime non_realtime, Clock& clock, RecordQueue& queue, const StopRequest& stop,
                            StatusBoard& board, GuardPage* page = nullptr, EarlierRuns* earlier = nullptr);

}  // namespace eha::acquisition
