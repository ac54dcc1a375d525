// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/place/probe.hpp"

#include <algorithm>
#include <cmath>

namespace eha::place {
namespace {

// Pinned by dead_sensor_campaign_test.cpp.
constexpr double kFirstShare = 0.02;  ///< of half the command range
constexpr double kGrowth = 1.5;
constexpr double kSlopeShare_per_s = 4.0;  ///< of half the command range
constexpr double kHold_s = 0.06;
constexpr double kReturnShare = 0.5;  ///< of the pulse's area
constexpr int kRefinements = 2;
constexpr double kMean_s = 0.2;
constexpr double kSettling_s = 0.1;
constexpr double kSeen_in = 0.002;
constexpr double kEnough_in = 0.006;  ///< ends a pulse
constexpr double kDrift_in = 0.006;   ///< from one mean to the next
constexpr double kFilter_s = 0.01;
constexpr double kDeviations = 6.0;

}  // namespace

Probe::Probe(const config::RigLimits& limits, double most_V, double period_s) noexcept
    : half_range_V_(0.5 * (limits.command_max_V - limits.command_min_V)),
      most_V_(most_V),
      slope_V_per_s_(std::min(limits.slew_V_per_s, kSlopeShare_per_s * half_range_V_)),
      period_s_(period_s) {}

void Probe::begin(double direction) noexcept {
  direction_ = direction;
  result_ = Result::none;
  forward_V_ = std::min(kFirstShare * half_range_V_, most_V_);
  is_return_ = false;
  seen_V_ = 0.0;
  unseen_V_ = 0.0;
  refinements_ = 0;
  has_last_ = false;
  begin_pulse();
}

void Probe::begin_pulse() noexcept {
  const bool is_last = forward_V_ >= most_V_;
  hold_s_ = is_last ? kHold_s : 0.0;
  amplitude_V_ = forward_V_;
  if (is_return_) {
    amplitude_V_ *= std::sqrt(kReturnShare);
    hold_s_ *= std::sqrt(kReturnShare);
  }
  enter(Phase::before);
}

void Probe::enter(Phase phase) noexcept {
  phase_ = phase;
  phase_s_ = 0.0;
  sum_in_ = 0.0;
  readings_ = 0;
}

double Probe::noise_in() const noexcept { return std::sqrt(variance_in2_); }

double Probe::least_in() const noexcept {
  // moved = after - just_before - r (just_before - before), each the mean of so many readings
  const double r = (kMean_s + kSettling_s + pulse_s_) / kMean_s;
  const double squares = 1.0 + (1.0 + r) * (1.0 + r) + r * r;
  return std::max(kSeen_in, kDeviations * noise_in() * std::sqrt(squares * period_s_ / kMean_s));
}

double Probe::offset_V(double place_in) noexcept {
  if (has_last_) {
    const double change_in = place_in - last_in_;
    ++changes_;
    const double weight = std::max(period_s_ / kMean_s, 1.0 / static_cast<double>(changes_));
    variance_in2_ += weight * (0.5 * change_in * change_in - variance_in2_);
  } else {
    filtered_in_ = place_in;
  }
  has_last_ = true;
  last_in_ = place_in;
  filtered_in_ += period_s_ / (kFilter_s + period_s_) * (place_in - filtered_in_);
  if (result_ != Result::none) return 0.0;
  phase_s_ += period_s_;
  sum_in_ += place_in;
  ++readings_;
  const double mean_in = sum_in_ / static_cast<double>(readings_);
  switch (phase_) {
    case Phase::before:
      if (phase_s_ < kMean_s) break;
      first_in_ = mean_in;
      enter(Phase::just_before);
      break;
    case Phase::just_before:
      if (phase_s_ < kMean_s) break;
      second_in_ = mean_in;
      if (std::abs(second_in_ - first_in_) >
          std::max(kDrift_in, kDeviations * noise_in() * std::sqrt(2.0 * period_s_ / kMean_s))) {
        result_ = Result::drifts;
      }
      offset_V_ = 0.0;
      is_falling_ = false;
      held_s_ = 0.0;
      enter(Phase::pulse);
      break;
    case Phase::pulse:
      drive();
      break;
    case Phase::settling:
      if (phase_s_ >= kSettling_s) enter(Phase::after);
      break;
    case Phase::after:
      if (phase_s_ < kMean_s) break;
      moved_in_ = mean_in - second_in_;
      judge();
      break;
  }
  return (is_return_ ? -direction_ : direction_) * offset_V_;
}

void Probe::drive() noexcept {
  const double step_V = slope_V_per_s_ * period_s_;
  const double enough_in = std::max(kEnough_in, kDeviations * noise_in() * std::sqrt(period_s_ / (2.0 * kFilter_s)));
  if (std::abs(filtered_in_ - second_in_) > enough_in) is_falling_ = true;
  if (is_falling_) {
    offset_V_ = std::max(0.0, offset_V_ - step_V);
  } else if (offset_V_ < amplitude_V_) {
    offset_V_ = std::min(amplitude_V_, offset_V_ + step_V);
  } else {
    held_s_ += period_s_;
    is_falling_ = held_s_ >= hold_s_;
  }
  if (!is_falling_ || offset_V_ > 0.0) return;
  pulse_s_ = phase_s_;
  enter(Phase::settling);
}

void Probe::judge() noexcept {
  const double drift_in = (second_in_ - first_in_) * (kMean_s + kSettling_s + pulse_s_) / kMean_s;
  moved_in_ = (is_return_ ? -direction_ : direction_) * (moved_in_ - drift_in);
  const double least = least_in();
  if (moved_in_ < -2.0 * least) {
    result_ = Result::backwards;
  } else if (!is_return_ && moved_in_ >= least) {
    seen_V_ = forward_V_;
    refine();
  } else if (seen_V_ > 0.0) {
    unseen_V_ = forward_V_;
    refine();
  } else if (!is_return_) {
    is_return_ = true;
    begin_pulse();
  } else if (forward_V_ >= most_V_) {
    result_ = Result::unseen;
  } else {
    is_return_ = false;
    unseen_V_ = forward_V_;
    forward_V_ = std::min(most_V_, kGrowth * forward_V_);
    begin_pulse();
  }
}

void Probe::refine() noexcept {
  if (refinements_ == kRefinements || unseen_V_ <= 0.0) {
    result_ = Result::seen;
    return;
  }
  ++refinements_;
  forward_V_ = std::sqrt(seen_V_ * unseen_V_);
  begin_pulse();
}

}  // namespace eha::place
