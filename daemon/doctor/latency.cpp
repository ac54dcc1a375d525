// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/latency.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <future>
#include <limits>
#include <memory>
#include <numbers>
#include <thread>
#include <vector>

#include "daemon/acquisition/clock.hpp"
#include "daemon/acquisition/record_queue.hpp"
#include "hal/sim/sim_rig.hpp"

namespace eha::doctor {
namespace {

using acquisition::RecordQueue;

constexpr double kRepetition_s = 1.0;
constexpr double kAmplitude_V = 1.0;
// Limits that are never reached. The simulated rod may rest on an end stop; a tick costs the same there.
constexpr double kOutOfReach = 1e9;

/// Drops the records of the queue in place of a run's writer.
class Drain {
 public:
  explicit Drain(RecordQueue& queue) : thread_([this, &queue] { run(queue); }) {}
  Drain(const Drain&) = delete;
  Drain& operator=(const Drain&) = delete;
  ~Drain() {
    ended_.store(true, std::memory_order_release);
    thread_.join();
  }

 private:
  void run(RecordQueue& queue) const {
    std::vector<acquisition::TickRecord> batch(RecordQueue::kCapacity / 8);
    while (!ended_.load(std::memory_order_acquire)) {
      if (queue.pop(batch.data(), batch.size()) == 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }

  std::atomic<bool> ended_{false};
  std::thread thread_;
};

}  // namespace

acquisition::RunReport measure_latency(double duration_s, config::RealtimeOptions realtime,
                                       const acquisition::StopRequest& stop,
                                       const std::function<void(const acquisition::Snapshot&)>& progress) {
  if (!(duration_s >= kShortestMeasurement_s && duration_s <= kLongestMeasurement_s)) {
    throw ConfigError("duration: expected " + std::to_string(kShortestMeasurement_s) + " to " +
                      std::to_string(kLongestMeasurement_s) + " s, got " + std::to_string(duration_s) + " s");
  }
  realtime.abort_consecutive_late = std::numeric_limits<int>::max();
  realtime.abort_total_late = std::numeric_limits<int>::max();

  const hal::SimOptions plant;
  config::RigLimits limits;
  limits.command_min_V = plant.command_min_V;
  limits.command_max_V = plant.command_max_V;
  limits.slew_V_per_s = kOutOfReach;
  limits.safe_V = -plant.valve_null_offset_V;
  limits.travel_min_in = -kOutOfReach;
  limits.travel_max_in = kOutOfReach;
  limits.stopping_deceleration_in_per_s2 = kOutOfReach;
  limits.velocity_limit_in_per_s = kOutOfReach;
  limits.following = config::Following{.gain_positive_in_per_V_s = kOutOfReach,
                                       .gain_negative_in_per_V_s = kOutOfReach,
                                       .null_V = limits.safe_V,
                                       .dead_band_V = plant.command_max_V,
                                       .limit_in = kOutOfReach,
                                       .pressure_delay_s = 0.0};

  const double repetitions = std::max(1.0, std::floor(duration_s / kRepetition_s));
  const double rows = std::max(1.0, std::round(duration_s / realtime.sample_period_s / repetitions));
  std::vector<double> table_V(static_cast<std::size_t>(rows));
  for (std::size_t k = 0; k < table_V.size(); ++k) {
    table_V[k] = limits.safe_V + kAmplitude_V * std::sin(2.0 * std::numbers::pi * static_cast<double>(k) / rows);
  }

  const std::unique_ptr<hal::Rig> rig = hal::open_rig(plant, limits.safe_V);
  acquisition::StateMachine machine;
  machine.reset();
  machine.arm();
  acquisition::MonotonicClock clock;
  const auto queue = std::make_unique<RecordQueue>();
  acquisition::StatusBoard board;
  const Drain drain(*queue);
  std::future<acquisition::RunReport> loop = std::async(std::launch::async, [&] {
    acquisition::TableSource source(table_V, static_cast<std::uint32_t>(repetitions));
    return acquisition::run(*rig, machine, source, limits, realtime, acquisition::NonRealtime::allow, clock, *queue,
                            stop, board);
  });
  while (loop.wait_for(std::chrono::milliseconds(100)) != std::future_status::ready) {
    if (progress) progress(board.read());
  }
  return loop.get();
}

std::vector<Gate> gates(const acquisition::RunReport& report) {
  return {{"latency_p99_9_us", report.latency.percentile_us(0.999), 50.0},
          {"latency_max_us", static_cast<double>(report.latency.maximum_ns()) * 1e-3, 150.0},
          {"execution_max_us", static_cast<double>(report.execution.maximum_ns()) * 1e-3, 300.0},
          {"skipped_ticks", static_cast<double>(report.counters.skipped), 0.0},
          {"lost_records", static_cast<double>(report.counters.dropped), 0.0}};
}

}  // namespace eha::doctor
