// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "config/rig_config.hpp"
#include "daemon/acquisition/limit_monitor.hpp"

namespace eha::acquisition {

/// Effect of too many late or skipped ticks.
enum class LatePolicy : std::uint8_t {
  abort,  ///< end the run safely
  count,  ///< only count: nothing moves on this rig
};

/// Decides whether a loop that misses its deadlines must end: too many late or skipped ticks in a row, or over time (a
/// total that loses one a second). A tick is late if it starts more than half a period after its time, skipped if it
/// never runs. Real-time safe.
class DeadlineMonitor {
 public:
  DeadlineMonitor(const config::RealtimeOptions& options, LatePolicy policy) noexcept
      : policy_(policy),
        consecutive_limit_(options.abort_consecutive_late),
        total_limit_(options.abort_total_late),
        ticks_per_second_(std::max<std::int64_t>(1, std::llround(1.0 / options.sample_period_s))) {}

  /// Counts a tick that ran, and `skipped` ticks before it that did not.
  [[nodiscard]] Breach note(std::uint32_t skipped, bool late) noexcept {
    const std::int64_t bad = static_cast<std::int64_t>(skipped) + (late ? 1 : 0);
    consecutive_ = bad == 0 ? 0 : consecutive_ + bad;
    total_ += bad;
    if (++ticks_ % ticks_per_second_ == 0 && total_ > 0) --total_;
    if (policy_ == LatePolicy::count) return {};
    if (consecutive_ >= consecutive_limit_) {
      return {Fault::consecutive_late, static_cast<double>(consecutive_), static_cast<double>(consecutive_limit_)};
    }
    if (total_ >= total_limit_) {
      return {Fault::total_late, static_cast<double>(total_), static_cast<double>(total_limit_)};
    }
    return {};
  }

 private:
  LatePolicy policy_;
  std::int64_t consecutive_limit_;
  std::int64_t total_limit_;
  std::int64_t ticks_per_second_;
  std::int64_t ticks_ = 0;
  std::int64_t consecutive_ = 0;
  std::int64_t total_ = 0;
};

}  // namespace eha::acquisition
