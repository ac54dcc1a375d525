// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "config/rig_config.hpp"
#include "daemon/acquisition/clock.hpp"
#include "daemon/acquisition/run.hpp"
#include "hal/rig.hpp"

namespace eha::acquisition {

inline config::RigLimits test_limits() {
  return {.command_min_V = -5.0,
          .command_max_V = 5.0,
          .slew_V_per_s = 100.0,
          .safe_V = 0.0,
          .travel_min_in = 0.2,
          .travel_max_in = 5.7,
          .stopping_deceleration_in_per_s2 = 400.0,
          .velocity_limit_in_per_s = 20.0,
          .frozen_sensor_s = 0.05};
}

/// 2 V amplitude at 2 Hz, beginning at its peak.
inline std::vector<double> cosine(std::size_t samples) {
  std::vector<double> table_V(samples);
  for (std::size_t k = 0; k < samples; ++k) {
    table_V[k] = 2.0 * std::cos(2.0 * std::numbers::pi * 2.0 * 0.001 * static_cast<double>(k));
  }
  return table_V;
}

/// A short run in virtual time with everything it needs; records are few enough to stay in the queue until the end.
struct Play {
  config::RigLimits limits = test_limits();
  config::RealtimeOptions realtime;
  std::vector<double> table_V = cosine(500);
  std::uint32_t repetitions = 1;
  VirtualClock clock;
  StopRequest stop;
  StateMachine machine;
  StatusBoard board;
  std::unique_ptr<RecordQueue> queue = std::make_unique<RecordQueue>();
  RunReport report;
  std::vector<TickRecord> rows;

  void on(hal::Rig& rig) {
    TableSource source(table_V, repetitions);
    on(rig, source);
  }

  void on(hal::Rig& rig, CommandSource& source) {
    if (machine.state() == State::faulted) machine.reset();
    machine.arm();
    report = run(rig, machine, source, limits, realtime, NonRealtime::refuse, clock, *queue, stop, board);
    drain();
  }

  void drain() {
    TickRecord row{};
    while (queue->pop(&row, 1) == 1) rows.push_back(row);
  }

  /// Position in `rows` of the first row in a state; rows.size() when there is none.
  [[nodiscard]] std::size_t first(State state) const {
    std::size_t i = 0;
    while (i < rows.size() && rows[i].state != state) ++i;
    return i;
  }
  [[nodiscard]] std::size_t count(State state) const {
    std::size_t n = 0;
    for (const TickRecord& row : rows) n += row.state == state ? 1 : 0;
    return n;
  }
};

}  // namespace eha::acquisition
