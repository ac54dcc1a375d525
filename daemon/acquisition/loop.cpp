// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/loop.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <thread>

namespace eha::acquisition {
namespace {

static_assert(sizeof(TickRecord) == GuardPage::kRowSize && GuardPage::kRows > RecordQueue::kCapacity);

constexpr std::int64_t kMostSkippedRows = 256;  // bounds the work of a tick; beyond it the gap shows in `sequence`

/// Page faults and preemptions of the calling thread since this was made.
class ThreadUsage {
 public:
  ThreadUsage() noexcept { getrusage(RUSAGE_THREAD, &before_); }
  void read_into(LoopCounters& counters) const noexcept {
    rusage now{};
    getrusage(RUSAGE_THREAD, &now);
    counters.minor_faults = now.ru_minflt - before_.ru_minflt;
    counters.major_faults = now.ru_majflt - before_.ru_majflt;
    counters.involuntary_switches = now.ru_nivcsw - before_.ru_nivcsw;
  }

 private:
  rusage before_{};
};

}  // namespace

void Loop::run() noexcept {
  // In virtual time nothing is driven, and the duration of a tick does not matter.
  const bool is_watched = page_ != nullptr && !clock_.is_virtual();
  if (is_watched) page_->begin_drive(gettid(), stall_limit_ns_);
  play();
  // A drive without an end is a loop that stands still: the guard switches the hydraulics off, and in the end kills the
  // process, so that eha-safe makes the rig safe on a card that it has opened anew. A card that is gone takes nothing
  // from anybody: this process keeps its record and says so.
  const bool is_gone = report_.fault.fault == Fault::device_removed;
  if (is_watched && (report_.safe_confirmed || is_gone)) page_->end_drive();
}

void Loop::play() noexcept {
  const ThreadUsage usage;
  const std::int64_t ticks_per_second = std::max<std::int64_t>(1, 1'000'000'000 / period_ns_);
  const std::int64_t begun_ns = clock_.now_ns();
  // Between two clocks that are read in turn this thread may wait. Read here after the other clock and in the ticks
  // before it, so that such a wait lowers the time of suspends that is counted and never is one.
  const std::int64_t suspended_before_ns = clock_.with_suspends_ns() - begun_ns;
  const std::int64_t origin_ns = begun_ns + period_ns_;
  for (std::int64_t k = 0; !engine_.finished(); ++k) {
    rest_if_the_card_does_not_answer(origin_ns + k * period_ns_);
    clock_.sleep_until(origin_ns + k * period_ns_);
    TickInputs inputs;
    // Before the clocks: who stops the run for a suspend that it has seen does not precede what they show of it.
    inputs.stops = stop_.count();
    const std::int64_t with_suspends_ns = clock_.with_suspends_ns();
    inputs.woken_ns = clock_.now_ns();
    inputs.suspended_ns = with_suspends_ns - inputs.woken_ns - suspended_before_ns;
    if (page_ != nullptr) {
      page_->beat();
      inputs.guard_has_tripped = page_->has_tripped();
    }
    const std::int64_t behind_ns = std::max<std::int64_t>(0, inputs.woken_ns - (origin_ns + k * period_ns_));
    const std::int64_t skipped = behind_ns / period_ns_;
    for (std::int64_t i = 0; i < std::min(skipped, kMostSkippedRows); ++i) {
      keep(engine_.skipped_row(static_cast<std::uint32_t>(k + i), (k + i) * period_ns_));
    }
    k += skipped;
    inputs.sequence = static_cast<std::uint32_t>(k);
    inputs.scheduled_ns = k * period_ns_;
    inputs.lateness_ns = behind_ns - skipped * period_ns_;
    inputs.skipped =
        static_cast<std::uint32_t>(std::min<std::int64_t>(skipped, std::numeric_limits<std::int32_t>::max()));
    inputs.stop = &stop_;
    inputs.sink_failing = sink_is_failing();
    tick(inputs, behind_ns);
    if (!clock_.is_virtual() && k % ticks_per_second == 0) usage.read_into(usage_);
    publish(inputs);
    if (clock_.is_virtual()) wait_for_writer();
  }
  if (!clock_.is_virtual()) usage.read_into(usage_);
  report_.counters = counters();
  report_.fault = engine_.fault();
  report_.experiment_ns = engine_.experiment_ns();
  report_.travel = engine_.travel();
  report_.velocity = engine_.velocity();
  report_.moved_in = engine_.moved_in();
  report_.safe_confirmed = engine_.safe_confirmed();
  report_.final_state = machine_.state();
  report_.stops_seen = static_cast<std::uint32_t>(stop_.count());
  report_.outcome = outcome();
}

void Loop::rest_if_the_card_does_not_answer(std::int64_t deadline_ns) noexcept {
  if (clock_.is_virtual() || machine_.state() != State::safe_stop) return;
  // Calls that wait busily for a second each leave no time to sleep. Without a sleep the system kills a process with a
  // real-time thread after some seconds (RLIMIT_RTTIME).
  const std::int64_t now_ns = clock_.now_ns();
  if (now_ns > deadline_ns) clock_.sleep_until(now_ns + period_ns_);
}

void Loop::tick(const TickInputs& inputs, std::int64_t behind_ns) noexcept {
  const TickRecord row = engine_.tick(inputs);
  keep(row);
  report_.latency.add(behind_ns, inputs.scheduled_ns);
  report_.execution.add(row.execution_ns, inputs.scheduled_ns);
  last_ = row;
}

void Loop::keep(const TickRecord& row) noexcept {
  if (!queue_.push(row)) {
    ++dropped_;
  } else if (page_ != nullptr) {
    page_->keep(&row);
  }
  queue_peak_ = std::max<std::uint64_t>(queue_peak_, queue_.fill());
}

bool Loop::sink_is_failing() const noexcept {
  // In virtual time the loop waits for the writer instead of outrunning it.
  const bool is_slow = !clock_.is_virtual() && queue_.fill() >= RecordQueue::kNearlyFull;
  return queue_.writer_failed() || dropped_ > 0 || is_slow;
}

void Loop::wait_for_writer() const noexcept {
  while (queue_.fill() > RecordQueue::kCapacity / 2 && !queue_.writer_failed()) std::this_thread::yield();
}

LoopCounters Loop::counters() const noexcept {
  LoopCounters all = engine_.counters();
  all.dropped = dropped_;
  all.queue_peak = clock_.is_virtual() ? 0 : queue_peak_;
  all.minor_faults = usage_.minor_faults;
  all.major_faults = usage_.major_faults;
  all.involuntary_switches = usage_.involuntary_switches;
  return all;
}

void Loop::publish(const TickInputs& inputs) noexcept {
  Snapshot snapshot;
  snapshot.state = machine_.state();
  snapshot.fault = last_.fault;
  snapshot.sequence = inputs.sequence;
  snapshot.experiment_row = engine_.rows_played(inputs.sequence);
  snapshot.experiment_rows = engine_.experiment_rows();
  snapshot.elapsed_ns = inputs.scheduled_ns;
  snapshot.requested_V = last_.requested_V;
  snapshot.applied_V = last_.applied_V;
  snapshot.displacement_in = last_.displacement_in;
  snapshot.velocity_in_per_s = engine_.velocity_in_per_s();
  snapshot.travel_share = engine_.travel_share();
  snapshot.velocity_share = engine_.velocity_share();
  snapshot.feedback_code = last_.feedback_code;
  snapshot.digital_inputs = last_.digital_inputs;
  snapshot.flags = last_.flags;
  snapshot.enable_contact = engine_.enable_contact();
  snapshot.latency_max_ns = report_.latency.maximum_ns();
  snapshot.execution_max_ns = report_.execution.maximum_ns();
  snapshot.counters = counters();
  board_.publish(snapshot);
}

Outcome Loop::outcome() const noexcept {
  switch (engine_.fault().fault) {
    case Fault::none:
      break;
    case Fault::second_stop:
      return Outcome::interrupted;
    case Fault::consecutive_late:
    case Fault::total_late:
      return Outcome::deadline;
    default:
      return Outcome::faulted;
  }
  if (stop_.outputs_taken()) return Outcome::interrupted;
  if (engine_.sink_failed() || dropped_ > 0 || queue_.writer_failed()) return Outcome::write_failed;
  return engine_.interrupted() ? Outcome::interrupted : Outcome::completed;
}

}  // namespace eha::acquisition
