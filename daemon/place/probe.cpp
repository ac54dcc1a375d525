// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/place/probe.hpp"

#include <algorithm>
#include <cmath>

namespace eha::place {
namespace {

// Pinned by dead_sensor_campaign_test.cpp.
constexpr double kFirstShare = 0.02;  ///< of half the command range
constexpr double kFirst_V = 0.1;      ///< at most
constexpr double kGrowth = 1.5;
constexpr double kSlopeShare_per_s = 4.0;  ///< of half the command range
constexpr double kSlope_V_per_s = 20.0;    ///< at most
constexpr double kMost_V = 1.5;
constexpr double kHold_s = 0.06;
// What a rod may move by grows with the volt-seconds, whatever the slew limit, the range and the tick are.
constexpr double kMost_Vs = kMost_V * (kMost_V / kSlope_V_per_s + kHold_s);  ///< of a pulse
constexpr double kReach_V = 1.0;       ///< that a low slew limit may take more volt-seconds for
constexpr double kMostSlow_Vs = 0.3;   ///< then
constexpr double kMostAlive_Vs = 0.5;  ///< of a pulse after a return that the sensor has seen
constexpr double kMostSum_Vs = 0.36;   ///< of the pulses before the rod is seen, those the other way taken off
constexpr double kUsualTick_s = 0.001;
constexpr double kReturnShare = 0.5;  ///< of the pulse's area
constexpr double kMostReturn_Vs = kReturnShare * kMost_Vs;
constexpr double kDescent = 5.0;  ///< from a pulse that was seen to the next lesser one
constexpr int kRefinements = 3;
constexpr double kFineEnough = 1.3;     ///< greatest that was not seen to least that was, volt-seconds
constexpr double kRepeatedShare = 0.5;  ///< of the least motion: one that only just was seen would be missed again
constexpr int kAgreeing = 2;
constexpr double kDrifting_Vs = 0.003;  ///< the first pulse at a rod that drifts, which leaves no time for lesser ones
constexpr int kAliveReturns = 2;
constexpr double kUnsteady_s = 5.0;
constexpr double kMean_s = 0.2;
constexpr double kRest_s = 0.4;  ///< a rod comes to rest that a pulse of 1 V at 2.5 V/s moves
constexpr double kSeen_in = 0.002;
constexpr double kEnough_in = 0.006;  ///< ends a pulse
constexpr double kDrift_in = 0.006;   ///< from one mean to the next
constexpr double kFilter_s = 0.01;
constexpr double kDeviations = 6.0;

}  // namespace

Probe::Probe(const config::RigLimits& limits, double most_V, double period_s) noexcept
    : half_range_V_(0.5 * (limits.command_max_V - limits.command_min_V)),
      most_V_(std::min(most_V, kMost_V)),
      full_slope_V_per_s_(std::min(kSlopeShare_per_s * half_range_V_, kSlope_V_per_s)),
      slope_V_per_s_(std::min(limits.slew_V_per_s, full_slope_V_per_s_)),
      period_s_(period_s) {
  const double reach_V = std::min(kReach_V, most_V_);
  last_Vs_ = std::max(std::min(kMost_Vs, most_V_ * (most_V_ / full_slope_V_per_s_ + kHold_s)),
                      std::min(kMostSlow_Vs, reach_V * reach_V / slope_V_per_s_));
  farthest_Vs_ = std::max(last_Vs_, std::min(kMostAlive_Vs, most_V_ * (most_V_ / slope_V_per_s_ + kHold_s)));
}

void Probe::begin(double direction) noexcept {
  direction_ = direction;
  result_ = Result::none;
  const double first_V = std::min({kFirstShare * half_range_V_, kFirst_V, most_V_});
  first_Vs_ = first_V * first_V / full_slope_V_per_s_;
  area_Vs_ = first_Vs_;
  is_return_ = false;
  returns_in_a_row_ = 0;
  is_confirmed_ = false;
  seen_Vs_ = 0.0;
  seen_V_ = 0.0;
  unseen_Vs_ = 0.0;
  refinements_ = 0;
  agreeing_ = 0;
  is_drifting_ = false;
  unsteady_s_ = 0.0;
  sum_Vs_ = 0.0;
  has_last_ = false;
  begin_pulse();
  enter(Phase::coming_to_rest);
}

void Probe::begin_pulse() noexcept {
  shape_pulse();
  // The drift is extrapolated over the pulse: over a long one from longer means.
  mean_s_ = std::max(kMean_s, 2.0 * peak_V_ / slope_V_per_s_ + hold_s_);
  means_ = 0;
  enter(Phase::before);
}

void Probe::shape_pulse() noexcept {
  double area_Vs = area_Vs_;
  if (is_return_) {
    // At least what lets a pulse that was seen be repeated.
    const double repeat_Vs = seen_Vs_ > 0.0 ? sum_Vs_ + area_Vs - kMostSum_Vs : 0.0;
    area_Vs = std::max(std::min(kReturnShare * area_Vs, kMostReturn_Vs), repeat_Vs);
  } else if (!is_confirmed_ && !is_alive()) {
    area_Vs = std::clamp(kMostSum_Vs - sum_Vs_, 0.0, area_Vs);
  }
  // The greatest peak of this area: peak^2 / slope + late peak = area, as the peak stands for a tick.
  const double late_s = std::max(0.0, period_s_ - kUsualTick_s);
  const double half_V = 0.5 * slope_V_per_s_ * late_s;
  const double most_V = is_return_ ? most_V_ * std::sqrt(kReturnShare) : most_V_;
  peak_V_ = std::min(most_V, std::sqrt(half_V * half_V + slope_V_per_s_ * area_Vs) - half_V);
  hold_s_ = peak_V_ > 0.0 ? std::max(0.0, area_Vs / peak_V_ - peak_V_ / slope_V_per_s_ - late_s) : 0.0;
}

void Probe::grow() noexcept {
  is_return_ = false;
  const double grown_Vs = kGrowth * kGrowth * area_Vs_;
  if (area_Vs_ >= last_Vs_) {
    area_Vs_ = std::min(farthest_Vs_, kGrowth * area_Vs_);
  } else {
    const double most_Vs = most_V_ * most_V_ / full_slope_V_per_s_;
    area_Vs_ = grown_Vs < std::min(most_Vs, last_Vs_) ? grown_Vs : last_Vs_;
  }
  begin_pulse();
}

void Probe::enter(Phase phase) noexcept {
  phase_ = phase;
  phase_s_ = 0.0;
  sum_in_ = 0.0;
  readings_ = 0;
}

bool Probe::is_alive() const noexcept { return returns_in_a_row_ >= kAliveReturns; }

double Probe::noise_in() const noexcept { return std::sqrt(variance_in2_); }

double Probe::least_in() const noexcept {
  // moved = after - before - r drift, each the mean of so many readings
  const double r = means_across();
  const double squares = 1.0 + (1.0 + r) * (1.0 + r) + r * r;
  return std::max(kSeen_in, kDeviations * noise_in() * std::sqrt(squares * period_s_ / mean_s_));
}

double Probe::needed_in() const noexcept {
  const bool is_repeated = !is_return_ && seen_Vs_ > 0.0 && area_Vs_ >= seen_Vs_;
  return is_repeated ? kRepeatedShare * least_in() : least_in();
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
    case Phase::coming_to_rest:
      if (phase_s_ >= kRest_s) enter(Phase::before);
      break;
    case Phase::before:
      if (phase_s_ < mean_s_) break;
      compare(mean_in);
      break;
    case Phase::pulse:
      drive();
      break;
    case Phase::settling:
      if (phase_s_ >= kSettling_s) enter(Phase::after);
      break;
    case Phase::after:
      if (phase_s_ < mean_s_) break;
      after_in_ = mean_in;
      moved_in_ = (is_return_ ? -direction_ : direction_) * (after_in_ - before_in_ - means_across() * drift_in_);
      if (std::abs(moved_in_) < needed_in()) {
        judge();
      } else {
        enter(Phase::later);
      }
      break;
    case Phase::later: {
      if (phase_s_ < mean_s_) break;
      // A drift that changes by itself moves the means, too: half as much again where it changes steadily.
      const double drift_in = mean_in - after_in_;
      const double r = means_across();
      moved_in_ = (is_return_ ? -direction_ : direction_) * (after_in_ - before_in_ - 0.5 * r * (drift_in_ + drift_in));
      if (std::abs(moved_in_) < r * std::abs(drift_in - drift_in_)) moved_in_ = 0.0;
      judge();
      break;
    }
  }
  return (is_return_ ? -direction_ : direction_) * offset_V_;
}

void Probe::compare(double mean_in) noexcept {
  ++means_;
  const double change_in = mean_in - before_in_;
  before_in_ = mean_in;
  enter(Phase::before);
  if (means_ == 1) return;
  const double limit_in =
      std::max(kDrift_in * mean_s_ / kMean_s, kDeviations * noise_in() * std::sqrt(2.0 * period_s_ / mean_s_));
  const bool moves = std::abs(change_in) > limit_in;
  agreeing_ = moves && std::abs(change_in - drift_in_) <= limit_in ? agreeing_ + 1 : 0;
  is_drifting_ = agreeing_ >= kAgreeing;
  drift_in_ = change_in;
  if (moves && !is_drifting_) {
    unsteady_s_ += mean_s_;
    if (unsteady_s_ < kUnsteady_s) return;
    moved_in_ = std::abs(change_in);
    result_ = Result::unsteady;
  }
  if (is_drifting_ && area_Vs_ < std::min(kDrifting_Vs, last_Vs_)) {
    area_Vs_ = std::min(kDrifting_Vs, last_Vs_);
    shape_pulse();
  }
  offset_V_ = 0.0;
  is_falling_ = false;
  held_s_ = 0.0;
  enter(Phase::pulse);
}

void Probe::drive() noexcept {
  const double step_V = slope_V_per_s_ * period_s_;
  const double enough_in = std::max(kEnough_in, kDeviations * noise_in() * std::sqrt(period_s_ / (2.0 * kFilter_s)));
  const double drift_in = is_drifting_ ? drift_in_ * (0.5 + phase_s_ / mean_s_) : 0.0;
  if (std::abs(filtered_in_ - before_in_ - drift_in) > enough_in) is_falling_ = true;
  if (is_falling_) {
    offset_V_ = std::max(0.0, offset_V_ - step_V);
  } else if (offset_V_ < peak_V_) {
    offset_V_ = std::min(peak_V_, offset_V_ + step_V);
  } else {
    held_s_ += period_s_;
    is_falling_ = held_s_ >= hold_s_;
  }
  sum_Vs_ += (is_return_ ? -period_s_ : period_s_) * offset_V_;
  if (!is_falling_ || offset_V_ > 0.0) return;
  pulse_s_ = phase_s_;
  enter(Phase::settling);
}

void Probe::judge() noexcept {
  const double least = least_in();
  if (moved_in_ < -2.0 * least) {
    result_ = Result::backwards;
  } else if (is_return_) {
    judge_return(moved_in_ >= least);
  } else {
    judge_pulse(moved_in_ >= needed_in());
  }
}

void Probe::judge_pulse(bool is_seen) noexcept {
  if (is_confirmed_) {
    is_last_seen_ = is_seen;
    if (is_seen) seen_V_ = peak_V_;
    (is_seen ? seen_Vs_ : unseen_Vs_) = area_Vs_;
    if (seen_Vs_ > unseen_Vs_) {
      refine();
      return;
    }
    // The least pulse that was seen is not seen again.
    is_confirmed_ = false;
    is_seen = false;
  } else if (is_seen && seen_Vs_ > 0.0) {
    is_confirmed_ = true;
    is_last_seen_ = true;
    unseen_Vs_ = 0.0;
    refinements_ = 0;
    seen_V_ = peak_V_;
    refine();
    return;
  }
  seen_Vs_ = is_seen ? area_Vs_ : 0.0;
  is_return_ = !is_seen || !is_drifting_;
  begin_pulse();
}

void Probe::judge_return(bool is_seen) noexcept {
  returns_in_a_row_ = is_seen ? returns_in_a_row_ + 1 : 0;
  if (seen_Vs_ > 0.0) {
    // One motion each way shows as much as two of one way.
    if (is_seen) returns_in_a_row_ = kAliveReturns;
    is_return_ = false;
    begin_pulse();
  } else if (area_Vs_ >= last_Vs_ && returns_in_a_row_ == 1) {
    begin_pulse();
  } else if (area_Vs_ >= (is_alive() ? farthest_Vs_ : last_Vs_)) {
    result_ = Result::unseen;
  } else {
    grow();
  }
}

void Probe::refine() noexcept {
  if (is_drifting_) {
    result_ = Result::drifts;
  } else if (unseen_Vs_ <= 0.0 && seen_Vs_ > first_Vs_) {
    area_Vs_ = std::max(first_Vs_, seen_Vs_ / kDescent);
    begin_pulse();
  } else if (unseen_Vs_ > 0.0 && refinements_ < kRefinements && seen_Vs_ > kFineEnough * unseen_Vs_) {
    ++refinements_;
    area_Vs_ = std::sqrt(seen_Vs_ * unseen_Vs_);
    begin_pulse();
  } else if (!is_last_seen_) {
    area_Vs_ = seen_Vs_;
    begin_pulse();
  } else {
    result_ = Result::seen;
  }
}

}  // namespace eha::place
