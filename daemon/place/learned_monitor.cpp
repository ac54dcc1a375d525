// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/place/learned_monitor.hpp"

#include <algorithm>
#include <cmath>

namespace eha::place {
namespace {

constexpr double kSlow_V = 0.05;               ///< that the filter trails the command by: 1 V/s
constexpr double kLearnt_s = 0.05;             ///< of slow motion in a step
constexpr double kLongest_s = 1.0;             ///< then its speed stands
constexpr double kLeastSpeed_in_per_s = 0.02;  ///< below it a step counts as dead band
constexpr double kLeastShare = 0.5;
constexpr double kMissing_in = 0.1;

}  // namespace

LearnedMonitor::LearnedMonitor(const config::RigLimits& limits, double period_s) noexcept
    : lowest_V_(limits.command_min_V),
      step_V_((limits.command_max_V - limits.command_min_V) / static_cast<double>(kSteps)),
      period_s_(period_s),
      motion_(period_s) {}

std::size_t LearnedMonitor::step_of(double command_V) const noexcept {
  return static_cast<std::size_t>(
      std::clamp((command_V - lowest_V_) / step_V_, 0.0, static_cast<double>(kSteps) - 0.5));
}

void LearnedMonitor::note(double command_V, double displacement_in) noexcept {
  motion_.note(command_V, displacement_in);
  check(motion_.speed_in_per_s());
  if (std::abs(motion_.trails_by_V()) < kSlow_V) learn(motion_.speed_in_per_s());
}

void LearnedMonitor::learn(double speed_in_per_s) noexcept {
  Step& step = steps_[step_of(motion_.command_V())];
  if (step.time_s > kLongest_s) return;
  step.time_s += period_s_;
  step.speed_in_per_s += period_s_ / step.time_s * (speed_in_per_s - step.speed_in_per_s);
}

void LearnedMonitor::check(double speed_in_per_s) noexcept {
  // The speed rises with the voltage: a step further in gives a bound.
  const std::size_t here = step_of(motion_.command_V());
  double extending = 0.0;
  double retracting = 0.0;
  for (std::size_t i = 0; i < here; ++i) {
    if (steps_[i].time_s >= kLearnt_s) extending = std::max(extending, steps_[i].speed_in_per_s);
  }
  for (std::size_t i = here + 1; i < kSteps; ++i) {
    if (steps_[i].time_s >= kLearnt_s) retracting = std::max(retracting, -steps_[i].speed_in_per_s);
  }
  const std::array<double, 2> due{extending, retracting};
  for (std::size_t i = 0; i < due.size(); ++i) {
    if (due[i] < kLeastSpeed_in_per_s || due[1 - i] > due[i]) continue;
    const double direction = i == 0 ? 1.0 : -1.0;
    missing_in_[i] = std::max(0.0, missing_in_[i] + (kLeastShare * due[i] - direction * speed_in_per_s) * period_s_);
    if (missing_in_[i] > kMissing_in && breach_.fault == acquisition::Fault::none) {
      breach_ = {acquisition::Fault::not_following, missing_in_[i], kMissing_in};
    }
  }
}

}  // namespace eha::place
