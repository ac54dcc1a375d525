// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/place/explorer.hpp"

#include <algorithm>
#include <cmath>

#include "config/characterisation.hpp"

namespace eha::place {
namespace {

using acquisition::Fault;

// Pinned by wrong_scale_campaign_test.cpp: rods of 0.1 to 2 in/(V s) whose scale is wrong by 0.4 to 2.5.
constexpr double kReturning_in_per_s = 0.1;
constexpr double kInside_in = 0.12;  ///< of explored travel ahead, in which the rod comes back to the slow speed
constexpr double kExploringFilter_s = 0.05;
constexpr double kLearntSlowly_s = 3.0;
constexpr double kMostExploringShare = 0.3;  ///< of half the command range
// Changes of the command, shares of half the command range a second.
constexpr double kSearch_per_s = 0.012;
constexpr double kReturn_per_s = 0.03;
constexpr double kCross_per_s = 0.06;  ///< through the dead band, with explored travel ahead
constexpr double kQuick_per_s = 0.2;   ///< against a rod that runs away
constexpr double kRunsAway = 3.0;      ///< times the wanted speed
constexpr double kMoves_in = 0.03;     ///< of a leg: the rod moves
constexpr double kProgress_in = 0.01;
constexpr double kStandstill_s = 4.0;
constexpr double kAtMost_s = 2.0;  ///< at the greatest command without progress
constexpr double kBackwards_in = 0.3;
constexpr double kBeyondSlow_V = 0.03;    ///< the slow speed is surely due
constexpr double kDue_s = 1.0;            ///< without progress
constexpr double kDueAfterPulse_s = 0.5;  ///< the same before the slow speed is known: less volts must have moved it
constexpr double kDueGrowth_per_s = 0.003;
constexpr double kKnownSlowly_s = 0.5;
constexpr double kFastest_in_per_s = 0.6;

}  // namespace

Explorer::Explorer(const config::RigLimits& limits, double window_in, double period_s) noexcept
    : middle_in_(limits.mid_travel_in()),
      safe_V_(limits.safe_V),
      half_range_V_(0.5 * (limits.command_max_V - limits.command_min_V)),
      period_s_(period_s),
      weight_(period_s / (kExploringFilter_s + period_s)),
      command_V_(limits.safe_V),
      quick_share_per_s_(kQuick_per_s),
      probe_(limits, limits.closed_loop_max_V.value_or(kMostExploringShare * half_range_V_), period_s),
      monitor_(period_s) {
  lowest_wanted_in_ = middle_in_ - window_in;
  highest_wanted_in_ = middle_in_ + window_in;
  most_V_ = limits.closed_loop_max_V.value_or(kMostExploringShare * half_range_V_);
  explored_.null_V = safe_V_;
}

void Explorer::begin(double place_in) noexcept {
  has_begun_ = true;
  filtered_in_ = place_in;
  explored_.lowest_in = place_in;
  explored_.highest_in = place_in;
  if (place_in < highest_wanted_in_) targets_in_[legs_++] = highest_wanted_in_;
  if (place_in > lowest_wanted_in_) targets_in_[legs_++] = lowest_wanted_in_;
  targets_in_[legs_++] = middle_in_;
  begin_leg();
}

void Explorer::begin_leg() noexcept {
  from_in_ = filtered_in_;
  best_in_ = 0.0;
  still_s_ = 0.0;
  still_from_in_ = 0.0;
  due_s_ = 0.0;
  if (leg_ >= legs_) return;
  direction_ = std::copysign(1.0, targets_in_[leg_] - filtered_in_);
  if (seen_V_[direction_ > 0.0 ? 0 : 1] > 0.0) return;
  is_probing_ = true;
  probe_.begin(direction_);
}

void Explorer::filter(double place_in) noexcept {
  const double moved_in = weight_ * (place_in - filtered_in_);
  filtered_in_ += moved_in;
  speed_in_per_s_ += weight_ * (moved_in / period_s_ - speed_in_per_s_);
  explored_.lowest_in = std::min(explored_.lowest_in, filtered_in_);
  explored_.highest_in = std::max(explored_.highest_in, filtered_in_);
}

double Explorer::voltage_V(const hal::RigReading& last) noexcept {
  if (!has_begun_) begin(last.displacement_in);
  filter(last.displacement_in);
  monitor_.note(command_V_, last.displacement_in);
  if (std::abs(speed_in_per_s_) > kFastest_in_per_s)
    trip({Fault::loop_speed, std::abs(speed_in_per_s_), kFastest_in_per_s});
  while (leg_ < legs_ && direction_ * (targets_in_[leg_] - filtered_in_) <= 0.0) {
    ++leg_;
    begin_leg();
  }
  if (leg_ < legs_ && is_probing_) {
    probe(last.displacement_in);
  } else if (leg_ < legs_) {
    drive();
  } else {
    if (slow_s_[0] > 0.0 && slow_s_[1] > 0.0) explored_.null_V = 0.5 * (slow_V_[0] + slow_V_[1]);
    command_V_ = explored_.null_V;
    rested_s_ += period_s_;
  }
  return command_V_;
}

double Explorer::pulsed_about_V() const noexcept {
  const std::size_t other = direction_ > 0.0 ? 1 : 0;
  if (slow_s_[other] < kKnownSlowly_s) return safe_V_;
  return direction_ > 0.0 ? std::max(safe_V_, slow_V_[other]) : std::min(safe_V_, slow_V_[other]);
}

void Explorer::probe(double place_in) noexcept {
  const double about_V = pulsed_about_V();
  command_V_ = std::clamp(about_V + probe_.offset_V(place_in), safe_V_ - most_V_, safe_V_ + most_V_);
  elapsed_s_ += period_s_;
  switch (probe_.result()) {
    case Probe::Result::none:
      return;
    case Probe::Result::unseen:
      trip({Fault::no_motion, probe_.moved_in(), probe_.least_in()});
      return;
    case Probe::Result::backwards:
      trip({Fault::unexplained_motion, -probe_.moved_in(), probe_.least_in()});
      return;
    case Probe::Result::unsteady:
      trip({Fault::unexplained_motion, probe_.moved_in(), probe_.least_in()});
      return;
    case Probe::Result::seen:
      seen_V_[direction_ > 0.0 ? 0 : 1] = std::min(most_V_, direction_ * (about_V - safe_V_) + probe_.seen_V());
      break;
    case Probe::Result::drifts:
      seen_V_[direction_ > 0.0 ? 0 : 1] = most_V_;
      break;
  }
  is_probing_ = false;
  from_in_ = filtered_in_;
}

bool Explorer::is_motion_due() const noexcept {
  const std::size_t i = direction_ > 0.0 ? 0 : 1;
  const double off_V = direction_ * (command_V_ - safe_V_);
  if (slow_s_[i] >= kKnownSlowly_s) return off_V >= direction_ * (slow_V_[i] - safe_V_) + kBeyondSlow_V;
  return off_V >= seen_V_[i];
}

void Explorer::drive() noexcept {
  const double speed = direction_ * speed_in_per_s_;
  const std::size_t i = direction_ > 0.0 ? 0 : 1;
  const double ahead_in =
      std::min(direction_ > 0.0 ? explored_.highest_in - filtered_in_ : filtered_in_ - explored_.lowest_in,
               direction_ * (targets_in_[leg_] - filtered_in_));
  const bool is_inside = ahead_in > kInside_in;
  const double wanted = is_inside && slow_s_[i] >= kLearntSlowly_s ? kReturning_in_per_s : kExploring_in_per_s;
  if (wanted < wanted_in_per_s_ && slow_s_[i] > 0.0) command_V_ = slow_V_[i];
  wanted_in_per_s_ = wanted;
  if (wanted == kExploring_in_per_s) learn(speed);
  double change = change_V_per_s(speed, wanted, is_inside);
  const bool stands = speed < 0.3 * kExploring_in_per_s;
  if (stands && is_motion_due()) {
    change = std::min(change, kDueGrowth_per_s);
    due_s_ += period_s_;
  }
  command_V_ += direction_ * half_range_V_ * period_s_ * change;
  command_V_ = std::clamp(command_V_, safe_V_ - most_V_, safe_V_ + most_V_);
  check();
}

double Explorer::change_V_per_s(double speed, double wanted, bool is_inside) noexcept {
  const double sign = speed > kRunsAway * wanted ? -1.0 : speed < -kExploring_in_per_s ? 1.0 : 0.0;
  if (sign != 0.0) {
    // Each change of sign is an oscillation of this loop.
    if (sign * quick_sign_ < 0.0) quick_share_per_s_ = std::max(kSearch_per_s, 0.5 * quick_share_per_s_);
    quick_sign_ = sign;
    return sign * quick_share_per_s_;
  }
  if (is_inside && speed < 0.3 * kExploring_in_per_s) return kCross_per_s;
  const double fastest = wanted > kExploring_in_per_s ? kReturn_per_s : kSearch_per_s;
  return fastest * std::clamp((wanted - speed) / (0.5 * wanted), -1.0, 1.0);
}

void Explorer::learn(double speed) noexcept {
  if (std::abs(speed - kExploring_in_per_s) > 0.5 * kExploring_in_per_s) return;
  const std::size_t i = direction_ > 0.0 ? 0 : 1;
  slow_s_[i] += period_s_;
  slow_V_[i] += period_s_ / std::min(slow_s_[i], 1.0) * (command_V_ - slow_V_[i]);
}

void Explorer::check() noexcept {
  const double way_in = direction_ * (filtered_in_ - from_in_);
  best_in_ = std::max(best_in_, way_in);
  if (way_in < -kBackwards_in) trip({Fault::unexplained_motion, -way_in, kBackwards_in});
  still_s_ += period_s_;
  if (best_in_ - still_from_in_ > kProgress_in) {
    still_from_in_ = best_in_;
    still_s_ = 0.0;
    due_s_ = 0.0;
  }
  const bool is_at_most = std::abs(command_V_ - safe_V_) >= 0.999 * most_V_;
  if ((best_in_ > kMoves_in && still_s_ > kStandstill_s) || (is_at_most && still_s_ > kAtMost_s)) {
    trip({Fault::no_motion, best_in_ - still_from_in_, kProgress_in, command_V_, still_s_});
  }
  const bool is_known = slow_s_[direction_ > 0.0 ? 0 : 1] >= kKnownSlowly_s;
  if (due_s_ > (is_known ? kDue_s : kDueAfterPulse_s)) {
    trip({Fault::no_motion, best_in_ - still_from_in_, kProgress_in, command_V_, due_s_});
  }
  elapsed_s_ += period_s_;
  if (elapsed_s_ > config::kLongestExploring_s)
    trip({Fault::not_in_place, std::abs(targets_in_[leg_] - filtered_in_), 0.0});
}

void Explorer::trip(const acquisition::Breach& breach) noexcept {
  if (breach_.fault == Fault::none) breach_ = breach;
}

}  // namespace eha::place
