// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/run.hpp"

#include <pthread.h>
#include <sys/resource.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <system_error>
#include <thread>

#include "daemon/acquisition/realtime.hpp"
#include "daemon/acquisition/tick_engine.hpp"

namespace eha::acquisition {
namespace {

constexpr std::int64_t kMostSkippedRows = 256;  // bounds the work of a tick; beyond it the gap shows in `sequence`
constexpr std::size_t kLoopStack = 1024 * 1024;
constexpr double kGreatestPeriod_s = 1.0;
constexpr double kLeastPeriod_s = 1e-4;

void require(bool condition, const std::string& message) {
  if (!condition) throw ConfigError(message);
}

void check(const Excitation& excitation, const config::RigLimits& limits, const config::RealtimeOptions& realtime,
           const hal::RigCapabilities& rig) {
  require(realtime.sample_period_s >= kLeastPeriod_s && realtime.sample_period_s <= kGreatestPeriod_s,
          "sample period: expected 0.0001 to 1 s, got " + std::to_string(realtime.sample_period_s) + " s");
  require(!excitation.table_V.empty(), "the excitation is empty; give the experiment a duration");
  require(std::all_of(excitation.table_V.begin(), excitation.table_V.end(), [](double u) { return std::isfinite(u); }),
          "the excitation holds a voltage that is not finite");
  require(excitation.repetitions >= 1 && excitation.repetitions <= std::numeric_limits<std::uint16_t>::max(),
          "repetitions: expected 1 to 65535, got " + std::to_string(excitation.repetitions));
  require(excitation.table_V.size() <=
              static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()) / excitation.repetitions,
          "the experiment is longer than 2147483647 ticks");
  require(limits.command_min_V < limits.command_max_V && limits.safe_V >= limits.command_min_V &&
              limits.safe_V <= limits.command_max_V,
          "rig limits: the safe voltage must lie between command_min_V and command_max_V");
  require(limits.command_min_V >= rig.command_min_V && limits.command_max_V <= rig.command_max_V,
          "rig limits: command_min_V to command_max_V must lie within the output range " +
              std::to_string(rig.command_min_V) + " to " + std::to_string(rig.command_max_V) + " V");
  require(limits.slew_V_per_s > 0.0 && std::isfinite(limits.slew_V_per_s), "rig limits: slew_V_per_s must be positive");
  require(limits.travel_min_in < limits.travel_max_in, "rig limits: travel_min_in must be below travel_max_in");
  require(limits.stopping_deceleration_in_per_s2 > 0.0, "rig limits: stopping_deceleration_in_per_s2 must be positive");
  require(limits.velocity_limit_in_per_s > 0.0, "rig limits: velocity_limit_in_per_s must be positive");
  require(limits.frozen_sensor_s >= 0.0, "rig limits: frozen_sensor_s must not be negative");
}

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

/// The loop of one run, from its first tick to idle or faulted. Real-time safe.
class Loop {
 public:
  Loop(TickEngine& engine, const StateMachine& machine, std::int64_t period_ns, Clock& clock, RecordQueue& queue,
       const StopRequest& stop, StatusBoard& board, RunReport& report) noexcept
      : engine_(engine),
        machine_(machine),
        period_ns_(period_ns),
        clock_(clock),
        queue_(queue),
        stop_(stop),
        board_(board),
        report_(report) {}

  void run() noexcept {
    const ThreadUsage usage;
    const std::int64_t ticks_per_second = std::max<std::int64_t>(1, 1'000'000'000 / period_ns_);
    const std::int64_t origin_ns = clock_.now_ns() + period_ns_;
    for (std::int64_t k = 0; !engine_.finished(); ++k) {
      clock_.sleep_until(origin_ns + k * period_ns_);
      TickInputs inputs;
      inputs.woken_ns = clock_.now_ns();
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
      inputs.stops = stop_.count();
      inputs.outputs_taken = stop_.outputs_taken();
      inputs.sink_failing = sink_is_failing();
      tick(inputs, behind_ns);
      if (!clock_.is_virtual() && k % ticks_per_second == 0) usage.read_into(usage_);
      publish(inputs);
      if (clock_.is_virtual()) wait_for_writer();
    }
    if (!clock_.is_virtual()) usage.read_into(usage_);
    report_.counters = counters();
    report_.stops_seen = static_cast<std::uint32_t>(stop_.count());
  }

 private:
  void tick(const TickInputs& inputs, std::int64_t behind_ns) noexcept {
    const TickRecord row = engine_.tick(inputs);
    keep(row);
    report_.latency.add(behind_ns, inputs.scheduled_ns);
    report_.execution.add(row.execution_ns, inputs.scheduled_ns);
    last_ = row;
  }

  void keep(const TickRecord& row) noexcept {
    if (!queue_.push(row)) ++dropped_;
    queue_peak_ = std::max<std::uint64_t>(queue_peak_, queue_.fill());
  }

  [[nodiscard]] bool sink_is_failing() const noexcept {
    // In virtual time the loop waits for the writer instead of outrunning it.
    const bool is_slow = !clock_.is_virtual() && queue_.fill() >= RecordQueue::kNearlyFull;
    return queue_.writer_failed() || dropped_ > 0 || is_slow;
  }

  void wait_for_writer() const noexcept {
    while (queue_.fill() > RecordQueue::kCapacity / 2 && !queue_.writer_failed()) std::this_thread::yield();
  }

  [[nodiscard]] LoopCounters counters() const noexcept {
    LoopCounters all = engine_.counters();
    all.dropped = dropped_;
    all.queue_peak = clock_.is_virtual() ? 0 : queue_peak_;
    all.minor_faults = usage_.minor_faults;
    all.major_faults = usage_.major_faults;
    all.involuntary_switches = usage_.involuntary_switches;
    return all;
  }

  void publish(const TickInputs& inputs) noexcept {
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
    snapshot.latency_max_ns = report_.latency.maximum_ns();
    snapshot.execution_max_ns = report_.execution.maximum_ns();
    snapshot.counters = counters();
    board_.publish(snapshot);
  }

  TickEngine& engine_;
  const StateMachine& machine_;
  std::int64_t period_ns_;
  Clock& clock_;
  RecordQueue& queue_;
  const StopRequest& stop_;
  StatusBoard& board_;
  RunReport& report_;
  TickRecord last_{};
  LoopCounters usage_;
  std::uint64_t dropped_ = 0;
  std::uint64_t queue_peak_ = 0;
};

/// Runs `work` in a thread with a stack of its own size and waits for it.
void run_in_thread(const std::function<void()>& work) {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kLoopStack);
  pthread_t thread{};
  const int error = pthread_create(
      &thread, &attributes,
      [](void* argument) -> void* {
        (*static_cast<const std::function<void()>*>(argument))();
        return nullptr;
      },
      const_cast<void*>(static_cast<const void*>(&work)));
  pthread_attr_destroy(&attributes);
  if (error != 0) {
    throw Error(ExitCode::io, "cannot start the loop's thread: " + std::generic_category().message(error));
  }
  pthread_join(thread, nullptr);
}

Outcome outcome_of(const TickEngine& engine, const LoopCounters& counters, const RecordQueue& queue,
                   const StopRequest& stop) {
  switch (engine.fault().fault) {
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
  if (stop.outputs_taken()) return Outcome::interrupted;
  if (engine.sink_failed() || counters.dropped > 0 || queue.writer_failed()) return Outcome::write_failed;
  return engine.interrupted() ? Outcome::interrupted : Outcome::completed;
}

}  // namespace

RunReport run(hal::Rig& rig, StateMachine& machine, const Excitation& excitation, const config::RigLimits& limits,
              const config::RealtimeOptions& realtime, NonRealtime non_realtime, Clock& clock, RecordQueue& queue,
              const StopRequest& stop, StatusBoard& board) {
  check(excitation, limits, realtime, rig.capabilities());
  require(machine.state() == State::armed,
          "the rig is " + std::string(to_text(machine.state())) + ", not armed; arm it first");
  require(
      !clock.is_virtual() || rig.capabilities().virtual_time,
      "virtual time is for simulated and replayed rigs; this one (" + rig.capabilities().backend + ") really moves");
  RunReport report;
  const bool moves_nothing = rig.capabilities().virtual_time;
  const auto run_loop = [&](LatePolicy policy) {
    TickEngine engine(rig, machine, excitation, limits, realtime, policy, clock);
    Loop(engine, machine, std::llround(realtime.sample_period_s * 1e9), clock, queue, stop, board, report).run();
    report.fault = engine.fault();
    report.safe_confirmed = engine.safe_confirmed();
    report.final_state = machine.state();
    report.outcome = outcome_of(engine, report.counters, queue, stop);
  };
  if (clock.is_virtual()) {
    run_loop(LatePolicy::abort);
    return report;
  }
  const RealtimeProcess process(report.realtime);
  bool refused = false;
  run_in_thread([&] {
    enter_realtime(realtime, report.realtime);
    const bool granted = report.realtime.fifo && report.realtime.memory_locked;
    refused = !granted && non_realtime == NonRealtime::refuse && !moves_nothing;
    if (!refused) run_loop(!granted && moves_nothing ? LatePolicy::count : LatePolicy::abort);
  });
  if (refused) {
    std::string message = "no real-time scheduling, and this rig really moves:";
    for (const std::string& sentence : report.realtime.refused) message += "\n" + sentence;
    throw PermissionError(message + "\nrun it through ehad, or on a bench allow it with --allow-non-realtime");
  }
  return report;
}

}  // namespace eha::acquisition
