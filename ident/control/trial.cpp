// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/control/trial.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace eha::ident {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr double kSettle_s = 1.0;  // after each move
constexpr double kHoldLead_s = 2.0;
constexpr double kSines = 2.0;

std::size_t ticks(double duration_s, double tick_s) {
  return static_cast<std::size_t>(std::ceil(duration_s / tick_s * (1.0 - 1e-12)));
}

/// Returns the longest duration of a move of the reference [s].
double move_s(const ReferenceLimits& limits, double way) {
  return std::abs(way) / limits.velocity + limits.velocity / limits.acceleration +
         2.0 * std::sqrt(std::abs(way) / limits.acceleration) + 4.0 * limits.acceleration / limits.jerk;
}

}  // namespace

std::optional<BadSetPoint> bad_set_point(const TrialPlan& plan) {
  const std::vector<SetPoint>& points = plan.reference;
  if (!points.empty() && points.front().time_s != 0.0) return BadSetPoint{0, SetPointFault::first_not_at_zero};
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0 && !(points[i].time_s > points[i - 1].time_s)) return BadSetPoint{i, SetPointFault::not_later};
    if (!(points[i].position >= plan.lowest && points[i].position <= plan.highest))
      return BadSetPoint{i, SetPointFault::outside_travel};
  }
  return std::nullopt;
}

TrialPlan trial_plan(const AxisSettings& settings) {
  const ReferenceLimits& limits = settings.reference;
  const double travel = limits.highest - limits.lowest;
  TrialPlan plan;
  plan.lowest = limits.lowest;
  plan.highest = limits.highest;
  plan.step = std::min(0.5, 0.1 * travel);
  plan.sine = std::min(0.2, 0.04 * travel);
  const double w = std::min(0.5 * limits.velocity / plan.sine, std::sqrt(0.5 * limits.acceleration / plan.sine));
  plan.sine_Hz = w / kTwoPi;
  return plan;
}

TrialMotion::TrialMotion(const AxisSettings& settings, const TrialPlan& plan, double home) noexcept
    : reference_(plan.reference),
      sweep_(plan.sweep && plan.reference.empty() ? &*plan.sweep : nullptr),
      home_(std::clamp(home, plan.lowest, plan.highest)),
      way_(home_ < 0.5 * (plan.lowest + plan.highest) ? plan.step : -plan.step),
      sine_(std::copysign(plan.sine, way_)),
      sine_rad_per_tick_(kTwoPi * plan.sine_Hz * settings.tick_s),
      tick_s_(settings.tick_s),
      lowest_(plan.lowest),
      highest_(plan.highest) {
  move_ = ticks(move_s(settings.reference, plan.step) + kSettle_s, tick_s_);
  const std::size_t rest = ticks(kSettle_s, tick_s_);
  const std::size_t period = ticks(1.0 / plan.sine_Hz, tick_s_);
  const double lead_s = std::min(kHoldLead_s, 0.5 * plan.hold_s);
  std::array<std::size_t, kParts> lengths{rest,
                                          move_,
                                          move_ * 2 * static_cast<std::size_t>(std::max(0, plan.trapezoids)),
                                          sweep_ != nullptr ? sweep_->rows() : 0,
                                          period,
                                          ticks((kSines + 1.0) / plan.sine_Hz, tick_s_) - period,
                                          rest,
                                          ticks(lead_s, tick_s_),
                                          ticks(plan.hold_s, tick_s_) - ticks(lead_s, tick_s_)};
  if (!reference_.empty()) lengths = {rest, 0, ticks(reference_.back().time_s, tick_s_), 0, 0, 0, rest, 0, 0};
  std::size_t end = 0;
  for (std::size_t i = 0; i < kParts; ++i) ends_[i] = end += lengths[i];
}

std::size_t TrialMotion::index(std::size_t row) const noexcept {
  std::size_t i = 0;
  while (i < kParts && row >= ends_[i]) ++i;
  return i;
}

TrialMotion::Part TrialMotion::part(std::size_t row) const noexcept {
  constexpr std::array<Part, kParts + 1> kAll{Part::rest, Part::step, Part::trapezoids, Part::sweep, Part::sine_lead,
                                              Part::sine, Part::rest, Part::hold_lead,  Part::hold,  Part::over};
  return kAll[index(row)];
}

std::size_t TrialMotion::since(std::size_t row) const noexcept {
  const std::size_t i = index(row);
  return i == 0 ? row : row - ends_[i - 1];
}

double TrialMotion::own_set_point(double time_s) const noexcept {
  const auto after = std::upper_bound(reference_.begin(), reference_.end(), time_s,
                                      [](double t, const SetPoint& point) { return t < point.time_s; });
  if (after == reference_.begin()) return reference_.front().position;
  if (after == reference_.end()) return reference_.back().position;
  const SetPoint& a = *(after - 1);
  return a.position + (after->position - a.position) * (time_s - a.time_s) / (after->time_s - a.time_s);
}

double TrialMotion::set_point(std::size_t row) const noexcept {
  const std::size_t i = index(row);
  if (!reference_.empty()) {
    if (i == kTrapezoids) return own_set_point(static_cast<double>(since(row)) * tick_s_);
    return i < kTrapezoids ? reference_.front().position : reference_.back().position;
  }
  const double centre = home_ + way_;
  if (i == kRest) return home_;
  if (i == kTrapezoids) return since(row) / move_ % 2 == 0 ? home_ : centre;
  if (i == kSweep) {
    const std::size_t k = since(row);
    const double share = static_cast<double>(k % sweep_->way_rows()) / static_cast<double>(sweep_->way_rows());
    // Continues in the same direction if there is room, else returns.
    const double way = std::copysign(sweep_->way(), way_);
    const bool has_room = centre + way >= lowest_ && centre + way <= highest_;
    return centre + (has_room ? way : -way) * (k / sweep_->way_rows() % 2 == 0 ? share : 1.0 - share);
  }
  if (i == kSineLead || i == kSine) {
    const auto k = static_cast<double>(row - ends_[kSweep]);
    return centre + sine_ * 0.5 * (1.0 - std::cos(sine_rad_per_tick_ * k));
  }
  return centre;
}

double TrialMotion::injected(std::size_t row) const noexcept {
  return index(row) == kSweep ? sweep_->injected(since(row)) : 0.0;
}

void TrialScore::take(std::size_t row, double reference, double rod) noexcept {
  const double error = reference - rod;
  const double way = motion_.way();
  switch (motion_.part(row)) {
    case TrialMotion::Part::step: {
      const double t = static_cast<double>(motion_.since(row)) * motion_.tick_s();
      const double end = motion_.home() + way;
      figures_.overshoot_in = std::max(figures_.overshoot_in, std::copysign(1.0, way) * (rod - end));
      if (std::abs(reference - end) < 1e-6 * std::abs(way) && ended_s_ < 0.0) ended_s_ = settled_s_ = t;
      if (ended_s_ >= 0.0 && std::abs(rod - end) > kSettledShare * std::abs(way)) settled_s_ = t;
      if (ended_s_ < 0.0) settled_s_ = t;
      break;
    }
    case TrialMotion::Part::trapezoids:
      trapezoid_square_ += error * error;
      trapezoid_rows_ += 1.0;
      figures_.following_worst_in = std::max(figures_.following_worst_in, std::abs(error));
      break;
    case TrialMotion::Part::sine:
      sine_square_ += error * error;
      sine_rows_ += 1.0;
      break;
    case TrialMotion::Part::hold:
      low_ = std::min(low_, rod);
      high_ = std::max(high_, rod);
      figures_.rest_error_in = std::max(figures_.rest_error_in, std::abs(error));
      figures_.travelled_in += std::abs(rod - last_);
      break;
    default:
      break;
  }
  last_ = rod;
}

TrialFigures TrialScore::figures() const noexcept {
  TrialFigures f = figures_;
  f.settling_s = ended_s_ < 0.0 ? settled_s_ : settled_s_ - ended_s_;
  if (trapezoid_rows_ > 0.0) f.following_rms_in = std::sqrt(trapezoid_square_ / trapezoid_rows_);
  if (sine_rows_ > 0.0) f.sine_rms_in = std::sqrt(sine_square_ / sine_rows_);
  f.standing_in = high_ > low_ ? high_ - low_ : 0.0;
  return f;
}

int SwingCounter::step(double command_V) noexcept {
  now_s_ += tick_s_;
  const double off_V = command_V - null_V_;
  const int side = off_V > width_V_ ? 1 : off_V < -width_V_ ? -1 : 0;
  if (side != 0 && side != side_) {
    if (side_ != 0) {
      if (count_ == kMost) {
        first_ = (first_ + 1) % kMost;
        --count_;
      }
      at_s_[(first_ + count_) % kMost] = now_s_;
      ++count_;
    }
    side_ = side;
  }
  while (count_ > 0 && now_s_ - at_s_[first_] > 1.0) {
    first_ = (first_ + 1) % kMost;
    --count_;
  }
  return static_cast<int>(count_);
}

double swing_width_V(const AxisSettings& s) {
  return 0.5 * s.inverse.dead_band + s.inverse.steepest() * s.feedback.kp * s.rest_error;
}

}  // namespace eha::ident
