// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "core/guard_page.hpp"
#include "daemon/acquisition/clock.hpp"
#include "daemon/acquisition/record_queue.hpp"
#include "daemon/acquisition/run.hpp"
#include "daemon/acquisition/state_machine.hpp"
#include "daemon/acquisition/status_board.hpp"
#include "daemon/acquisition/stop_request.hpp"
#include "daemon/acquisition/tick_engine.hpp"

namespace eha::acquisition {

/// Connections of a loop; all of them must outlive the loop.
struct LoopLinks {
  Clock& clock;
  RecordQueue& queue;
  const StopRequest& stop;
  StatusBoard& board;
  GuardPage* page = nullptr;        ///< shared with the guard; none: there is no guard
  std::int64_t stall_limit_ns = 0;  ///< for the guard, see GuardPage::begin_drive
};

/// The tick loop of one run. Each period, on a grid that never shifts, it sleeps until the absolute deadline, records
/// missed ticks, ticks the engine, queues the record, counts and publishes the state.
class Loop {
 public:
  Loop(TickEngine& engine, const StateMachine& machine, std::int64_t period_ns, const LoopLinks& links,
       RunReport& report) noexcept
      : engine_(engine),
        machine_(machine),
        period_ns_(period_ns),
        clock_(links.clock),
        queue_(links.queue),
        stop_(links.stop),
        board_(links.board),
        page_(links.page),
        stall_limit_ns_(links.stall_limit_ns),
        report_(report) {}

  /// Runs in the calling thread until the engine has finished, and fills in the report except `realtime`.
  /// Real-time safe, except that on a virtual clock it waits for the queue's consumer while the queue is half full.
  void run() noexcept;

 private:
  void play() noexcept;
  void rest_if_the_card_does_not_answer(std::int64_t deadline_ns) noexcept;
  void tick(const TickInputs& inputs, std::int64_t behind_ns) noexcept;
  void keep(const TickRecord& row) noexcept;
  void publish(const TickInputs& inputs) noexcept;
  void wait_for_writer() const noexcept;
  [[nodiscard]] bool sink_is_failing() const noexcept;
  [[nodiscard]] LoopCounters counters() const noexcept;
  [[nodiscard]] Outcome outcome() const noexcept;

  TickEngine& engine_;
  const StateMachine& machine_;
  std::int64_t period_ns_;
  Clock& clock_;
  RecordQueue& queue_;
  const StopRequest& stop_;
  StatusBoard& board_;
  GuardPage* page_;
  std::int64_t stall_limit_ns_;
  RunReport& report_;
  TickRecord last_{};
  LoopCounters usage_;
  std::uint64_t dropped_ = 0;
  std::uint64_t queue_peak_ = 0;
};

}  // namespace eha::acquisition
