// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/place/speed_slope.hpp"

#include <algorithm>
#include <cmath>

namespace eha::place {
namespace {

// Pinned by track_campaign_test.cpp.
constexpr double kForgets_s = 1.0;
constexpr double kOpen_V = 0.05;  ///< the corner of the dead band has no slope
constexpr double kOpen_s = 0.2;   ///< then the filters have forgotten it
constexpr double kLeastWeight_s = 0.3;
constexpr double kLeastSpread_in_per_s = 0.02;
constexpr double kCorrelated_s = 0.2;  ///< readings so near have one error: two filters of 0.05 s
constexpr double kErrors = 2.0;
constexpr double kLeastShare = 0.7;
constexpr double kLow_s = 0.2;

}  // namespace

SpeedSlope::SpeedSlope(double period_s) noexcept
    : period_s_(period_s), kept_(std::max(0.0, 1.0 - period_s / kForgets_s)) {}

void SpeedSlope::note(double direction, double open_V, double due_in_per_s, double speed_in_per_s) noexcept {
  if (direction != direction_ || open_V < kOpen_V) {
    sums_ = {};
    open_s_ = 0.0;
    low_s_ = 0.0;
  }
  direction_ = direction;
  open_s_ += period_s_;
  if (open_s_ < kOpen_s) return;
  const auto add = [&](double& sum, double value) { sum = kept_ * sum + period_s_ * value; };
  add(sums_.weight_s, 1.0);
  add(sums_.due, due_in_per_s);
  add(sums_.speed, speed_in_per_s);
  add(sums_.due_due, due_in_per_s * due_in_per_s);
  add(sums_.due_speed, due_in_per_s * speed_in_per_s);
  add(sums_.speed_speed, speed_in_per_s * speed_in_per_s);
  low_s_ = looks_low() ? low_s_ + period_s_ : 0.0;
}

bool SpeedSlope::is_low() const noexcept { return low_s_ > kLow_s; }

bool SpeedSlope::looks_low() noexcept {
  if (sums_.weight_s < kLeastWeight_s) return false;
  const double mean_due = sums_.due / sums_.weight_s;
  mean_in_per_s_ = sums_.speed / sums_.weight_s;
  least_mean_in_per_s_ = kLeastShare * mean_due;
  const double variance_due = sums_.due_due / sums_.weight_s - mean_due * mean_due;
  const double variance_speed = sums_.speed_speed / sums_.weight_s - mean_in_per_s_ * mean_in_per_s_;
  const double covariance = sums_.due_speed / sums_.weight_s - mean_due * mean_in_per_s_;
  if (variance_due < kLeastSpread_in_per_s * kLeastSpread_in_per_s) return false;
  const double slope = covariance / variance_due;
  const double residual = std::max(0.0, variance_speed - slope * covariance);
  const double error = std::sqrt(residual / variance_due * kCorrelated_s / sums_.weight_s);
  return slope + kErrors * error < kLeastShare && mean_in_per_s_ < least_mean_in_per_s_;
}

}  // namespace eha::place
