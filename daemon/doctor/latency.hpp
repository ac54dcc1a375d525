// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "config/rig_config.hpp"
#include "daemon/acquisition/run.hpp"
#include "daemon/acquisition/status_board.hpp"
#include "daemon/acquisition/stop_request.hpp"

namespace eha::doctor {

constexpr double kShortestMeasurement_s = 0.1;
constexpr double kLongestMeasurement_s = 65535.0;

/// Measures the tick loop on this machine without a rig: runs it in real time on the simulated actuator as shipped.
/// Counts late and skipped ticks without ending. Without real-time privileges it uses ordinary scheduling, which
/// RunReport::realtime reports.
/// @param duration_s  kShortestMeasurement_s to kLongestMeasurement_s
/// @param realtime    period, priority and CPU of the loop; its limits on late ticks are ignored
/// @param stop        ends it early: outcome `interrupted`, with the measurements so far
/// @param progress    called some ten times a second in this thread
/// @throws ConfigError  as acquisition::run. Blocks for the duration. Not thread-safe.
[[nodiscard]] acquisition::RunReport measure_latency(double duration_s, config::RealtimeOptions realtime,
                                                     const acquisition::StopRequest& stop,
                                                     const std::function<void(const acquisition::Snapshot&)>& progress);

/// One requirement on the loop.
struct Gate {
  std::string name;  ///< with its unit: "latency_p99_9_us"
  double value = 0.0;
  double limit = 0.0;  ///< greatest value allowed
  [[nodiscard]] bool met() const noexcept { return value <= limit; }
};

/// The requirements at 1 kHz on a PREEMPT_RT kernel: wake-up latency p99.9 of 50 us and maximum of 150 us (LinuxCNC
/// calls 20 to 50 us good), execution of 300 us, no skipped tick, no record lost.
[[nodiscard]] std::vector<Gate> gates(const acquisition::RunReport& report);

}  // namespace eha::doctor
