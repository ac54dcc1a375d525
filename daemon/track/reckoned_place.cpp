// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/track/reckoned_place.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "config/stopping_distance.hpp"

namespace eha::track {
namespace {

// Pinned by track_campaign_test.cpp and reckoned_place_test.cpp.
constexpr double kFilter_s = 0.05;
constexpr double kGainShare = 0.12;
constexpr double kSpareShare = 0.06;  ///< of the way: the rod may be so much faster than the file says
constexpr double kValveError_V = 0.03;
constexpr double kCreep_in_per_s = 0.003;
constexpr double kLeast_in = 0.03;
constexpr std::array<double, 2> kDirections{1.0, -1.0};

}  // namespace

ReckonedPlace::ReckonedPlace(const config::RigLimits& limits, double period_s)
    : limits_(limits), period_s_(period_s), weight_(period_s / (kFilter_s + period_s)) {
  if (!limits.following) return;
  valve_ = config::valve_estimate(*limits.following);
  const double gain = std::max(valve_->gain_positive_in_per_V_s, valve_->gain_negative_in_per_V_s);
  null_in_ = (kValveError_V * gain + kCreep_in_per_s) * period_s;
}

void ReckonedPlace::note(double displacement_in, double applied_V) noexcept {
  if (!valve_) return;
  if (!has_begun_) {
    has_begun_ = true;
    filtered_V_ = applied_V;
    filtered_in_ = displacement_in;
  }
  filtered_V_ += weight_ * (applied_V - filtered_V_);
  const double moved_in = weight_ * (displacement_in - filtered_in_);
  filtered_in_ += moved_in;
  const double speed = valve_->velocity_in_per_s(filtered_V_);
  const double explained_in = kGainShare * std::abs(speed) * period_s_ + null_in_;
  for (std::size_t i = 0; i < kDirections.size(); ++i) {
    const double d = kDirections[i];
    const double gap_in = d * (speed * period_s_ - moved_in);
    beyond_in_[i] = std::max(0.0, beyond_in_[i] + gap_in - explained_in);
    farther_in_[i] = beyond_in_[i] > 0.0 ? farther_in_[i] + gap_in + kSpareShare * std::abs(speed) * period_s_ : 0.0;
    if (beyond_in_[i] < kLeast_in || breach_.fault != acquisition::Fault::none) continue;
    const double stopping_in = config::stopping_distance_in(limits_, period_s_, std::max(0.0, d * speed));
    const double limit_in = i == 0 ? limits_.travel_max_in : limits_.travel_min_in;
    if (d * (displacement_in - limit_in) + farther_in_[i] + stopping_in > 0.0) {
      breach_ = {acquisition::Fault::wrong_place, d * farther_in_[i], limit_in};
    }
  }
}

}  // namespace eha::track
