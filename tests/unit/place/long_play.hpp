// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cmath>
#include <thread>

#include "daemon/place/place_source.hpp"
#include "tests/unit/acquisition/play.hpp"

namespace eha::place {

/// The shipped simulated rig's limits, with what its [following] says.
inline config::RigLimits limits_of_the_simulated_rig() {
  config::RigLimits limits = acquisition::test_limits();
  limits.slew_V_per_s = 20.0;
  limits.travel_min_in = 0.15;
  limits.travel_max_in = 5.75;
  limits.stopping_deceleration_in_per_s2 = 200.0;
  limits.velocity_limit_in_per_s = 8.0;
  limits.frozen_sensor_s = 0.5;
  limits.following = config::Following{
      .gain_positive_in_per_V_s = 0.074, .gain_negative_in_per_V_s = 0.065, .null_V = -0.2, .dead_band_V = 0.2};
  return limits;
}

/// Plays while the queue is emptied, so that runs may be long.
struct LongPlay : acquisition::Play {
  /// @returns where the rod is at the end [in]
  double move(hal::Rig& rig, double target_in, double time_out_s = 60.0) {
    limits = used_limits;
    PlaceSource source(PlaceController(limits, realtime.sample_period_s, target_in),
                       static_cast<std::uint32_t>(std::lround(time_out_s / realtime.sample_period_s)), begin);
    return play_on(rig, source);
  }

  double play_on(hal::Rig& rig, acquisition::CommandSource& source) {
    if (machine.state() == acquisition::State::faulted) machine.reset();
    machine.arm();
    std::atomic<bool> over{false};
    std::thread reader([&] {
      acquisition::TickRecord row{};
      while (!over || queue->fill() > 0) {
        if (queue->pop(&row, 1) == 1) {
          rows.push_back(row);
        } else {
          std::this_thread::yield();
        }
      }
    });
    report = acquisition::run(rig, machine, source, limits, realtime, acquisition::NonRealtime::refuse, clock, *queue,
                              stop, board);
    over = true;
    reader.join();
    return rows.back().displacement_in;
  }

  Begin begin = Begin::within_limits;
  config::RigLimits used_limits = limits_of_the_simulated_rig();
};

}  // namespace eha::place
