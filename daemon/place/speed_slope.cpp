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
    line_ = {};
    open_s_ = 0.0;
    low_s_ = 0.0;
  }
  direction_ = direction;
  open_s_ += period_s_;
  if (open_s_ < kOpen_s) return;
  line_.add(kept_, period_s_, due_in_per_s, speed_in_per_s);
  low_s_ = looks_low() ? low_s_ + period_s_ : 0.0;
}

bool SpeedSlope::is_low() const noexcept { return low_s_ > kLow_s; }

bool SpeedSlope::looks_low() noexcept {
  if (line_.weight_s() < kLeastWeight_s) return false;
  mean_in_per_s_ = line_.mean_y();
  least_mean_in_per_s_ = kLeastShare * line_.mean_x();
  const double variance_due = line_.variance_x();
  if (variance_due < kLeastSpread_in_per_s * kLeastSpread_in_per_s) return false;
  const double slope = line_.slope();
  const double residual = std::max(0.0, line_.variance_y() - slope * line_.covariance());
  const double error = std::sqrt(residual / variance_due * kCorrelated_s / line_.weight_s());
  return slope + kErrors * error < kLeastShare && mean_in_per_s_ < least_mean_in_per_s_;
}

}  // namespace eha::place
