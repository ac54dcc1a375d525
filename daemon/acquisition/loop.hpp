// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "daemon/acquisition/clock.hpp"
#include "daemon/acquisition/record_queue.hpp"
#include "daemon/acquisition/run.hpp"
#include "daemon/acquisition/state_machine.hpp"
#include "daemon/acquisition/status_board.hpp"
#include "daemon/acquisition/stop_request.hpp"
#include "daemon/acquisition/tick_engine.hpp"

namespace eha::acquisition {

/// Runs an engine in the calling thread, one tick each period on a grid that never shifts, until it has finished:
/// sleeps to the absolute deadline, puts down what was missed, ticks, hands the record over, counts, publishes.
/// Real-time safe, except that on a virtual clock it waits for the queue's consumer while the queue is half full.
/// @param report  everything but `realtime` is filled in
void run_loop(TickEngine& engine, const StateMachine& machine, std::int64_t period_ns, Clock& clock, RecordQueue& queue,
              const StopRequest& stop, StatusBoard& board, RunReport& report) noexcept;

}  // namespace eha::acquisition
