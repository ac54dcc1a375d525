// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/control/axis_design.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

constexpr double kSlewShare = 0.4;        // of the command's slew that the reference's acceleration may use
constexpr double kSpeedShare = 0.7;       // of the speed that the command range gives
constexpr double kOfVelocityLimit = 0.5;  // of the rig
constexpr double kJerkLags = 6.0;         // time to full acceleration, in lags of the plant
constexpr double kLeastJerk_s = 0.04;     // the same at least [s]
constexpr double kSpeedReserve = 1.5;     // greatest speed of the loop over the reference's
constexpr double kNoiseInTick = 2.5;      // standard deviations of the command's change that the slew must pass
constexpr double kTrackNoise = 0.02;      // of the command range, RMS
constexpr double kHoldNoise = 0.005;      // the same when holding
constexpr double kRestNoise = 3.0;        // standard deviations of a reading within which the rod counts as at rest
constexpr double kRestLsb = 2.0;
// Share of rest_error over which the inverse crosses the dead band. A share of 1 raises the following error by a third;
// a share of a half adds more noise to the command than the gain is worth.
constexpr double kSmoothedRest = 0.65;
constexpr double kLeastSmoothing = 0.01;  // of the reference's velocity
constexpr int kNoisePoints = 96;
constexpr double kLeastShare = 0.2;  // of the gain that the model itself allows
constexpr int kShareBisections = 6;
constexpr std::size_t kComparedEvery = 3;  // takes every third point of the grid if only errors are compared
constexpr double kBeyondBound = 0.05;      // share of the draws beyond each bound of a margin

/// Completes the settings that follow from the gains.
void complete(AxisSettings& s, const AxisTask& task) {
  s.rest_error = std::max(kRestNoise * task.noise, kRestLsb * task.lsb);
  s.inverse.smoothing = std::max(kSmoothedRest * s.feedback.kp * s.rest_error, kLeastSmoothing * s.reference.velocity);
  s.tracking_s = s.feedback.ki > 0.0 ? std::max(s.feedback.kp / s.feedback.ki, 10.0 * s.tick_s) : 0.0;
}

double noise_share(AxisSettings settings, const Feedback& feedback, const AxisTask& task) {
  settings.feedback = feedback;
  complete(settings, task);
  const CommandNoise noise = command_noise(settings, task.noise);
  const double range = task.command_max - task.command_min;
  const double most = (task.purpose == AxisPurpose::hold ? kHoldNoise : kTrackNoise) * range;
  return std::max(noise.rms / most, kNoiseInTick * noise.change_rms / (task.slew_per_s * task.tick_s));
}

std::vector<double> filter_ticks(FeedbackKind kind) {
  if (kind == FeedbackKind::pid || kind == FeedbackKind::fopid) return {3.0, 8.0, 20.0};
  return {0.0, 1.5, 3.0, 5.0, 8.0, 13.0, 20.0, 32.0};
}

double quantile(const std::vector<double>& sorted, double share) {
  const double at = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  if (!std::isfinite(sorted[above]) || !std::isfinite(sorted[below])) {
    return at - static_cast<double>(below) < 0.5 ? sorted[below] : sorted[above];
  }
  return sorted[below] + (at - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace

Interval interval(double value, std::vector<double> draws, double beyond) {
  if (draws.empty()) return {value, value, value};
  std::sort(draws.begin(), draws.end());
  // The draws add a dead time to the model's, so that the model's value may lie at the edge of theirs.
  return {value, std::min(value, quantile(draws, beyond)), std::max(value, quantile(draws, 1.0 - beyond))};
}

ReferenceLimits reference_limits(const AxisPlant& plant, const AxisTask& task) {
  const ValveNumbers& valve = plant.valve;
  const double gain = std::min(valve.gain_positive, valve.gain_negative);
  const double room_V = std::min(task.command_max - valve.null, valve.null - task.command_min) - valve.dead_band;
  const double lag_s = std::max(0.0, plant.inverse.acceleration);
  const double most_s = 0.125 * static_cast<double>(kMostTaps) * task.tick_s;
  const double jerk_s = std::min(std::max(kLeastJerk_s, kJerkLags * lag_s), most_s);
  ReferenceLimits limits{.lowest = task.lowest, .highest = task.highest};
  limits.velocity = std::min(kOfVelocityLimit * task.velocity_limit, kSpeedShare * gain * std::max(room_V, 0.0));
  limits.acceleration = kSlewShare * gain * task.slew_per_s * std::min(1.0, jerk_s / std::max(lag_s, 1e-9));
  limits.jerk = limits.acceleration / jerk_s;
  return limits;
}

CommandNoise command_noise(const AxisSettings& settings, double noise) {
  AxisSettings fast = settings;
  fast.feedback.ki = 0.0;  // the integrator moves the command slowly
  const AxisCoefficients c = coefficients(fast);
  const double slope = settings.inverse.steepest();
  CommandNoise result;
  // The readings' noise is white: int |C|^2 dtheta / pi over 0..pi, with theta = pi x^2 to be denser at low
  // frequencies.
  for (int i = 0; i < kNoisePoints; ++i) {
    const double x = (i + 0.5) / kNoisePoints;
    const double theta = std::numbers::pi * x * x;
    const double weight = 2.0 * x / kNoisePoints;
    const double power = std::norm(sampled_feedback(c, theta / settings.tick_s));
    result.rms += weight * power;
    result.change_rms += weight * power * 4.0 * std::pow(std::sin(0.5 * theta), 2);
  }
  result.rms = noise * slope * std::sqrt(result.rms);
  result.change_rms = noise * slope * std::sqrt(result.change_rms);
  return result;
}

MarginIntervals margin_intervals(const AxisSettings& settings, const AxisPlant& plant) {
  const AxisCoefficients c = coefficients(settings);
  const std::size_t n = plant.grid_rad_s.size();
  std::vector<Complex> feedback;
  for (const double w : plant.grid_rad_s) feedback.push_back(sampled_feedback(c, w));
  const double order = plant.order_at_zero + (settings.feedback.ki > 0.0 ? 1.0 : 0.0);
  std::vector<Complex> loop(n);
  const auto margins_of = [&](const std::vector<Complex>& response) {
    for (std::size_t i = 0; i < n; ++i) loop[i] = feedback[i] * response[i];
    return loop_margins(plant.grid_rad_s, loop, order);
  };
  const LoopMargins nominal = margins_of(plant.response);
  std::vector<double> ms;
  std::vector<double> mt;
  std::vector<double> phase;
  std::vector<double> gain;
  std::vector<double> delay;
  std::vector<double> peaks;
  int stable = 0;
  for (const std::vector<Complex>& response : plant.drawn_responses) {
    const LoopMargins m = margins_of(response);
    ms.push_back(m.ms);
    mt.push_back(m.mt);
    phase.push_back(m.is_stable ? m.phase_deg : 0.0);
    gain.push_back(m.is_stable ? m.gain : 0.0);
    delay.push_back(m.is_stable ? m.delay_s : 0.0);
    peaks.push_back(std::max(m.ms, m.mt));
    stable += m.is_stable ? 1 : 0;
  }
  MarginIntervals result;
  std::sort(peaks.begin(), peaks.end());
  result.peak95 = peaks.empty() ? std::max(nominal.ms, nominal.mt) : quantile(peaks, 0.95);
  result.ms = interval(nominal.ms, std::move(ms), kBeyondBound);
  result.mt = interval(nominal.mt, std::move(mt), kBeyondBound);
  result.phase_deg = interval(nominal.phase_deg, std::move(phase), kBeyondBound);
  result.gain = interval(nominal.gain, std::move(gain), kBeyondBound);
  result.delay_s = interval(nominal.delay_s, std::move(delay), kBeyondBound);
  result.crossover_rad_s = nominal.crossover_rad_s;
  result.stable_share = plant.drawn_responses.empty()
                            ? (nominal.is_stable ? 1.0 : 0.0)
                            : static_cast<double>(stable) / static_cast<double>(plant.drawn_responses.size());
  return result;
}

AxisDesign with_share(const AxisDesign& design, const AxisPlant& plant, const AxisTask& task, double share) {
  AxisDesign less = design;
  Feedback& f = less.settings.feedback;
  f.kp *= share;
  f.kd *= share;
  f.ki *= share * share;  // the integral time grows as the loop becomes slower
  complete(less.settings, task);
  less.feedback.feedback = f;
  less.feedback.noise_share = noise_share(less.settings, f, task);
  less.margins = margin_intervals(less.settings, plant);
  return less;
}

std::optional<AxisDesign> design_axis(const AxisPlant& plant, const AxisTask& task, FeedbackKind kind) {
  AxisSettings base;
  base.tick_s = task.tick_s;
  base.kind = kind;
  const ValveNumbers& valve = plant.valve;
  base.inverse = {.null = valve.null,
                  .dead_band = valve.dead_band,
                  .gain_positive = valve.gain_positive,
                  .gain_negative = valve.gain_negative};
  base.reference = reference_limits(plant, task);
  base.feed_forward = {.position_rate = plant.inverse.position,
                       .rest = plant.rest,
                       .acceleration_s = plant.inverse.acceleration + 0.5 * task.tick_s};
  base.command_min = task.command_min;
  base.command_max = task.command_max;
  base.slew_per_s = task.slew_per_s;
  base.most_speed = kSpeedReserve * base.reference.velocity +
                    std::abs(plant.inverse.position) *
                        std::max(std::abs(task.highest - plant.rest), std::abs(task.lowest - plant.rest));
  if (!(base.reference.velocity > 0.0 && base.reference.acceleration > 0.0)) return std::nullopt;

  const PlantResponse response{plant.grid_rad_s, plant.response, plant.order_at_zero};
  std::optional<AxisDesign> best;
  double least = std::numeric_limits<double>::infinity();
  double binding = 0.0;
  for (const double ticks : filter_ticks(kind)) {
    const double filter_s = ticks * task.tick_s;
    DesignLimits limits{.sensitivity = task.sensitivity};
    if (task.noise > 0.0) {
      limits.noise_share = [&](const Feedback& feedback) { return noise_share(base, feedback, task); };
    }
    const auto found =
        design_feedback(kind, response, limits, filter_s,
                        integrates(kind) ? DesignCriterion::squared_error : DesignCriterion::integrated_error);
    if (!found) continue;
    AxisDesign design{.settings = base, .feedback = *found};
    design.settings.feedback = found->feedback;
    complete(design.settings, task);
    design.margins = margin_intervals(design.settings, plant);
    if (design.margins.peak95 > task.sensitivity) {
      // The draws are worse than the model: finds the largest share of the gain that 95 % of them tolerate.
      double low = kLeastShare;
      double high = 1.0;
      const AxisDesign whole = design;
      design = with_share(whole, plant, task, low);
      if (design.margins.peak95 > task.sensitivity) continue;
      for (int i = 0; i < kShareBisections; ++i) {
        const double middle = 0.5 * (low + high);
        AxisDesign less = with_share(whole, plant, task, middle);
        if (less.margins.peak95 > task.sensitivity) {
          high = middle;
        } else {
          low = middle;
          design = std::move(less);
        }
      }
      design.feedback.squared_error = squared_load_error(response, design.settings.feedback);
    }
    const double cost = integrates(kind) ? design.feedback.squared_error : 1.0 / design.settings.feedback.kp;
    if (cost < least) {
      least = cost;
      binding = design.feedback.noise_share;
      best = std::move(design);
    }
  }
  if (best) best->noise_binds = binding > 0.98;
  return best;
}

double gain_of_fractional_orders(const AxisPlant& plant, const AxisTask& task, const AxisDesign& pid) {
  PlantResponse coarse;
  coarse.order_at_zero = plant.order_at_zero;
  for (std::size_t i = 0; i < plant.grid_rad_s.size(); i += kComparedEvery) {
    coarse.w_rad_s.push_back(plant.grid_rad_s[i]);
    coarse.response.push_back(plant.response[i]);
  }
  DesignLimits limits{.sensitivity = pid.feedback.sensitivity};
  if (task.noise > 0.0) {
    limits.noise_share = [&](const Feedback& feedback) { return noise_share(pid.settings, feedback, task); };
  }
  const double filter_s = pid.settings.feedback.filter_s;
  const auto rms = [&](FeedbackKind kind) {
    const auto found = design_feedback(kind, coarse, limits, filter_s, DesignCriterion::squared_error);
    return found ? std::sqrt(found->squared_error) : std::numeric_limits<double>::infinity();
  };
  const double fractional = rms(FeedbackKind::fopid);
  return std::isfinite(fractional) ? rms(FeedbackKind::pid) / fractional : 1.0;
}

}  // namespace eha::ident
