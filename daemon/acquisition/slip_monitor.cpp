// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/slip_monitor.hpp"

#include <algorithm>
#include <cmath>

#include "daemon/acquisition/slip_limit.hpp"

namespace eha::acquisition {
namespace {

// Pinned by slip_monitor_test.cpp.
constexpr double kLeast_in = 0.01;
constexpr double kNoiseDeviations = 8.0;
constexpr double kNoise_s = 0.5;        ///< time constant of the noise's estimate
constexpr int kNoiseReadings = 20;      ///< before them it is not known
constexpr double kMostNoise_in = 0.05;  ///< 8 deviations of the noisiest sensor that is armed, and some more
constexpr double kSteady_s = 0.01;      ///< interference comes back sooner
constexpr int kSteadyReadings = 5;      ///< the same at a long tick

}  // namespace

double SlipMonitor::noise_in() const noexcept {
  return readings_ > kNoiseReadings ? kLeast_in + kNoiseDeviations * std::sqrt(variance_in2_) : kMostNoise_in;
}

double SlipMonitor::slipped_in() const noexcept {
  return slipped_in_ + (std::abs(step_in_) > noise_in() ? step_in_ : 0.0);
}

Breach SlipMonitor::check(double displacement_in, double velocity_in_per_s, double since_s, double longest_s) noexcept {
  const double change_in = displacement_in - last_in_;
  const double jump_in = change_in - velocity_in_per_s * since_s;
  const bool jumps = readings_ > 0 && std::abs(jump_in) > velocity_limit_in_per_s_ * longest_s + noise_in();
  if (jumps) {
    step_in_ += jump_in;
    steady_s_ = 0.0;
  } else {
    steady_s_ += since_s;
    if (readings_ > 1) {
      // The second difference has six times the noise's variance and nothing of a steady motion.
      const double bend_in = change_in - last_change_in_;
      const double weight = std::max(std::min(1.0, since_s / kNoise_s), 1.0 / readings_);
      variance_in2_ += weight * (bend_in * bend_in / 6.0 - variance_in2_);
    }
    last_change_in_ = change_in;
  }
  last_in_ = displacement_in;
  readings_ = std::min(readings_ + 1, 1 << 20);
  if (step_in_ == 0.0 || steady_s_ < std::max(kSteady_s, (kSteadyReadings - 0.5) * since_s)) return {};
  if (std::abs(step_in_) > noise_in()) slipped_in_ += step_in_;
  step_in_ = 0.0;
  if (std::abs(slipped_in_) > kMostSlip_in)
    return {Fault::sensor_slip, slipped_in_, std::copysign(kMostSlip_in, slipped_in_)};
  return {};
}

}  // namespace eha::acquisition
