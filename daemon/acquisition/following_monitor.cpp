// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/following_monitor.hpp"

#include <algorithm>
#include <cmath>

#include "config/valve_estimate.hpp"

namespace eha::acquisition {
namespace {

constexpr double kFilter_s = 0.05;
constexpr double kEarly_V = 0.2;
constexpr double kSag_in_per_s = 0.05;  ///< of a sound rod at the valve's null
constexpr double kNullStds = 2.0;
constexpr double kComesToRest_s = 0.5;
constexpr std::array<double, 2> kDirections{1.0, -1.0};

// Without [following]; pinned by the campaign of simulated rigs in following_campaign_test.cpp.
constexpr double kFallbackShare = 1.0 / 32.0;  ///< of the gain that fills the velocity limit at half the command range
constexpr double kFallbackMissing_in = 0.02;
constexpr double kFallbackExcess_in = 0.1;

}  // namespace

FollowingRule following_rule(const config::RigLimits& limits) noexcept {
  FollowingRule rule;
  if (limits.following) {
    const config::Following& given = *limits.following;
    rule.least_gain_in_per_V_s = {given.gain_positive_in_per_V_s, given.gain_negative_in_per_V_s};
    for (std::size_t i = 0; i < kDirections.size(); ++i) {
      rule.greatest_gain_in_per_V_s[i] = 2.0 * rule.least_gain_in_per_V_s[i];
    }
    rule.null_V = given.null_V;
    rule.dead_band_V = given.dead_band_V;
    rule.early_V = kEarly_V;
    const double null_slack_V = kNullStds * config::valve_uncertainty(given).null_V;
    for (std::size_t i = 0; i < kDirections.size(); ++i) {
      const double sag_V = kSag_in_per_s / rule.greatest_gain_in_per_V_s[i];
      rule.waiting_early_V[i] = std::min(kEarly_V, std::max(null_slack_V, sag_V));
    }
    rule.missing_limit_in = given.limit_in;
    rule.excess_limit_in = given.limit_in;
    rule.pressure_delay_s = given.pressure_delay_s;
    return rule;
  }
  const double full_gain = limits.velocity_limit_in_per_s / (0.5 * (limits.command_max_V - limits.command_min_V));
  rule.least_gain_in_per_V_s.fill(kFallbackShare * full_gain);
  rule.greatest_gain_in_per_V_s.fill(full_gain);
  rule.dead_band_V = kFallbackDeadBand_V;
  rule.early_V = kFallbackDeadBand_V;
  rule.waiting_early_V.fill(kFallbackDeadBand_V);
  rule.missing_limit_in = kFallbackMissing_in;
  rule.excess_limit_in = kFallbackExcess_in;
  return rule;
}

void FollowingMonitor::begin(std::int64_t at_ns) noexcept {
  has_begun_ = true;
  pressure_ns_ = at_ns + static_cast<std::int64_t>(rule_.pressure_delay_s / kSecondsPerNanosecond);
}

Breach FollowingMonitor::check(std::int64_t at_ns, double displacement_in, double applied_V) noexcept {
  if (!has_reading_) {
    has_reading_ = true;
    last_ns_ = at_ns;
    filtered_V_ = applied_V;
    filtered_in_ = displacement_in;
    return {};
  }
  const double since_last_s = static_cast<double>(at_ns - last_ns_) * kSecondsPerNanosecond;
  last_ns_ = at_ns;
  const double weight = since_last_s / (kFilter_s + since_last_s);
  filtered_V_ += weight * (applied_V - filtered_V_);
  const double moved_in = weight * (displacement_in - filtered_in_);
  filtered_in_ += moved_in;
  if (!has_begun_) return {};
  Breach breach;
  for (std::size_t i = 0; i < kDirections.size(); ++i) {
    const double d = kDirections[i];
    const double command_V = d * (filtered_V_ - rule_.null_V);
    const double outside_V = command_V - rule_.dead_band_V;
    if (outside_V > 0.0 && at_ns > pressure_ns_) {
      const double due_in = rule_.least_gain_in_per_V_s[i] * outside_V * since_last_s;
      missing_in_[i] = std::max(0.0, missing_in_[i] + due_in - d * moved_in);
      left_in_[i] = std::max(0.0, left_in_[i] + due_in - d * moved_in);
      rests_s_[i] = 0.0;
      unmoved_in_[i] = left_in_[i];
      rests_at_in_[i] = filtered_in_;
    } else if (command_V > -rule_.dead_band_V && rests_s_[i] < kComesToRest_s) {
      left_in_[i] = std::clamp(unmoved_in_[i] - d * (filtered_in_ - rests_at_in_[i]), 0.0, unmoved_in_[i]);
      rests_s_[i] += since_last_s;
    }
    const double early_V = at_ns > pressure_ns_ ? rule_.early_V : rule_.waiting_early_V[i];
    const double most_in = rule_.greatest_gain_in_per_V_s[i] * std::max(0.0, command_V + early_V) * since_last_s;
    excess_in_[i] = std::max(0.0, excess_in_[i] + d * moved_in - most_in);
    peak_missing_ = std::max(peak_missing_, missing_in_[i] / rule_.missing_limit_in);
    peak_excess_ = std::max(peak_excess_, excess_in_[i] / rule_.excess_limit_in);
    if (missing_in_[i] > rule_.missing_limit_in) {
      breach = {Fault::not_following, missing_in_[i], rule_.missing_limit_in};
    } else if (excess_in_[i] > rule_.excess_limit_in) {
      breach = {Fault::unexplained_motion, excess_in_[i], rule_.excess_limit_in};
    }
  }
  return breach;
}

}  // namespace eha::acquisition
