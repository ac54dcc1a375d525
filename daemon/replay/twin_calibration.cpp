// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/replay/twin_calibration.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>

#include "core/error.hpp"
#include "core/millimetre_key.hpp"
#include "daemon/replay/replay.hpp"
#include "daemon/replay/twin_parameter.hpp"
#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/uncertainty/covariance.hpp"

namespace eha::replay {
namespace {

constexpr double kDefaultBounds = 5.0;  // factor of the value, to both sides
constexpr double kLargestVoltage_V = 5.0;
constexpr double kDifference = 1e-4;  // of a parameter's size
constexpr int kMostIterations = 25;
constexpr double kSmallestGain = 1e-7;  // least relative fall of the cost for another step
constexpr double kFirstDamping = 1e-3;
constexpr double kMostDamping = 1e8;
constexpr int kMostHalvings = 8;
constexpr double kSubStepMargin = 1.05;
constexpr double kShortest_s = 2.0;
constexpr const char* kAlike = "{} and {} cannot be told apart by this record; calibrate one of them";
constexpr const char* kFirstPosition = "initial_displacement_in";

/// A coordinate of the fit.
struct Coordinate {
  std::string key;  ///< kFirstPosition for the rod's first position
  double low;
  double high;
  double size;  ///< typical magnitude
};

class Fit {
 public:
  Fit(const hal::SimOptions& start, std::vector<Coordinate> coordinates, const Eigen::VectorXd& volts,
      const Eigen::VectorXd& measured_in, double step_s, const ident::Executor& executor)
      : start_(start),
        coordinates_(std::move(coordinates)),
        volts_(volts),
        step_s_(step_s),
        executor_(executor),
        rows_(std::max<Eigen::Index>(1, std::lround(kMean_s / step_s))),
        first_(std::lround(kLeftOut_s / step_s)) {
    measured_ = means(measured_in);
  }

  [[nodiscard]] hal::SimOptions options(const Eigen::VectorXd& theta) const {
    hal::SimOptions options = start_;
    for (std::size_t i = 0; i < coordinates_.size(); ++i) {
      const double value = theta[static_cast<Eigen::Index>(i)];
      options = coordinates_[i].key == kFirstPosition ? starting_at(options, value)
                                                      : with_value(options, coordinates_[i].key, value);
    }
    return options;
  }

  /// Returns the integration step for these values, the given one halved as often as necessary; nothing if the options
  /// make no physical sense. One Jacobian uses one step: another one would cause a jump of the output.
  [[nodiscard]] std::optional<double> sub_step_us(const Eigen::VectorXd& theta) const {
    hal::SimOptions tried = options(theta);
    for (int halved = 0; halved < kMostHalvings; ++halved) {
      const double step_us = tried.sub_step_us;
      tried.sub_step_us *= kSubStepMargin;
      const auto issues = hal::check(tried);
      if (issues.empty()) return step_us;
      if (issues.front().key != "sub_step_us") return {};
      tried.sub_step_us = 0.5 * step_us;
    }
    return {};
  }

  /// Returns the residual of the simulation; nothing if the options make no physical sense.
  [[nodiscard]] std::optional<Eigen::VectorXd> residual(const Eigen::VectorXd& theta,
                                                        std::optional<double> step_us) const {
    if (!step_us) return {};
    hal::SimOptions tried = options(theta);
    tried.sub_step_us = *step_us;
    if (!hal::check(tried).empty()) return {};
    const Eigen::VectorXd left = measured_ - means(displacement_in(tried, volts_, step_s_));
    return left.allFinite() ? std::optional(left) : std::nullopt;
  }

  /// Returns the derivatives of the simulated means by each coordinate, in units of its size.
  [[nodiscard]] Eigen::MatrixXd jacobian(const Eigen::VectorXd& theta, const Eigen::VectorXd& residual_here) const {
    Eigen::MatrixXd j(residual_here.size(), theta.size());
    const std::optional<double> step_us = sub_step_us(theta);
    executor_(coordinates_.size(), [&](std::size_t i) {
      const auto column = static_cast<Eigen::Index>(i);
      const Coordinate& c = coordinates_[i];
      Eigen::VectorXd moved = theta;
      const double step = kDifference * c.size * (theta[column] + kDifference * c.size > c.high ? -1.0 : 1.0);
      moved[column] += step;
      const std::optional<Eigen::VectorXd> there = residual(moved, step_us);
      j.col(column) = there ? Eigen::VectorXd((residual_here - *there) / (step / c.size))
                            : Eigen::VectorXd(Eigen::VectorXd::Zero(residual_here.size()));
    });
    return j;
  }

  [[nodiscard]] Eigen::VectorXd moved(const Eigen::VectorXd& theta, const Eigen::VectorXd& scaled_step) const {
    Eigen::VectorXd next = theta;
    for (Eigen::Index i = 0; i < next.size(); ++i) {
      const Coordinate& c = coordinates_[static_cast<std::size_t>(i)];
      next[i] = std::clamp(next[i] + c.size * scaled_step[i], c.low, c.high);
    }
    return next;
  }

  [[nodiscard]] const std::vector<Coordinate>& coordinates() const { return coordinates_; }

 private:
  [[nodiscard]] Eigen::VectorXd means(const Eigen::VectorXd& rows) const {
    const Eigen::Index count = (rows.size() - first_) / rows_;
    Eigen::VectorXd all(count);
    for (Eigen::Index i = 0; i < count; ++i) all[i] = rows.segment(first_ + i * rows_, rows_).mean();
    return all;
  }

  hal::SimOptions start_;
  std::vector<Coordinate> coordinates_;
  const Eigen::VectorXd& volts_;
  double step_s_;
  const ident::Executor& executor_;
  Eigen::Index rows_;
  Eigen::Index first_;
  Eigen::VectorXd measured_;
};

bool is_voltage(const std::string& key) { return key.ends_with("_V"); }

std::vector<Coordinate> coordinates_for(const hal::SimOptions& start, const std::vector<CalibrationRequest>& requests) {
  std::vector<Coordinate> coordinates;
  for (const CalibrationRequest& request : requests) {
    const double value = value_of(start, request.key);
    const double usual = std::abs(value_of(hal::SimOptions{}, request.key));
    Coordinate c{request.key, value / kDefaultBounds, value * kDefaultBounds, std::max(std::abs(value), usual)};
    if (request.key == "valve_null_offset_V") {
      c.low = -kLargestVoltage_V;
      c.high = kLargestVoltage_V;
    } else if (is_voltage(request.key)) {
      c.low = 0.0;
      c.high = std::max(c.high, usual * kDefaultBounds);
    }
    if (request.bounds) std::tie(c.low, c.high) = *request.bounds;
    if (!(c.low < c.high && value >= c.low && value <= c.high)) {
      throw UsageError(
          fmt::format("{}: expected bounds around its value {:g}, got {:g}:{:g}", request.key, value, c.low, c.high));
    }
    for (const Coordinate& other : coordinates) {
      if (other.key == c.key) throw UsageError(c.key + ": asked for twice");
    }
    coordinates.push_back(std::move(c));
  }
  coordinates.push_back({kFirstPosition, 0.0, start.stroke_mm / kMillimetresPerInch, 1.0});
  return coordinates;
}

/// Returns half the 95 % interval of one parameter if only it and the first position were unknown, over its size.
double alone(const Eigen::MatrixXd& j, Eigen::Index i, const ident::ResidualModel& residual) {
  Eigen::MatrixXd two(j.rows(), 2);
  two << j.col(i), j.col(j.cols() - 1);
  const ident::Uncertainty u = ident::uncertainty(two, {"parameter", kFirstPosition}, residual);
  const double variance = u.covariance(0, 0);
  return u.indistinguishable.empty() && std::isfinite(variance) ? u.interval_factor * std::sqrt(variance) : 1e300;
}

/// Throws for parameters that the record does not determine.
void require_determined(const std::vector<Coordinate>& coordinates, const Eigen::MatrixXd& j,
                        const ident::Uncertainty& known, const ident::ResidualModel& residual) {
  std::vector<std::string> sentences;
  const auto count = static_cast<Eigen::Index>(coordinates.size()) - 1;
  const auto lost = [&](Eigen::Index i) {
    const auto& names = known.indistinguishable;
    const bool named =
        std::find(names.begin(), names.end(), coordinates[static_cast<std::size_t>(i)].key) != names.end();
    return named || !(known.interval_factor * std::sqrt(known.covariance(i, i)) <= kWidestInterval);
  };
  for (Eigen::Index i = 0; i < count; ++i) {
    if (!lost(i)) continue;
    const std::string& key = coordinates[static_cast<std::size_t>(i)].key;
    if (!(alone(j, i, residual) <= kWidestInterval)) {
      sentences.push_back(
          fmt::format("{}: the record does not determine it, its 95 % interval is wider than +-{:g} %; leave it out, "
                      "or record faster motion",
                      key, 100.0 * kWidestInterval));
      continue;
    }
    // The parameter with the most similar effect on the output.
    Eigen::Index partner = i == 0 ? 1 : 0;
    double most = -1.0;
    for (Eigen::Index k = 0; k < count; ++k) {
      if (k == i) continue;
      const double norm = j.col(i).norm() * j.col(k).norm();
      const double alike = norm > 0.0 ? std::abs(j.col(i).dot(j.col(k))) / norm : 0.0;
      const double score = lost(k) ? 1.0 + alike : alike;
      if (score > most) {
        most = score;
        partner = k;
      }
    }
    const std::string& other = coordinates[static_cast<std::size_t>(partner)].key;
    const std::string mirrored = fmt::format(kAlike, other, key);
    if (std::find(sentences.begin(), sentences.end(), mirrored) == sentences.end()) {
      sentences.push_back(fmt::format(kAlike, key, other));
    }
  }
  if (sentences.empty()) return;
  throw DataError(fmt::format("{}", fmt::join(sentences, "\n")));
}

/// A rod that moves where the simulated cylinder has none is followed by no parameter. @throws DataError
void require_stroke(const hal::SimOptions& start, const Eigen::VectorXd& measured_in) {
  constexpr double kBeyond = 0.02;  // of the stroke: noise, and an offset of the sensor
  const double stroke_mm = start.stroke_mm;
  const double lowest_mm = kMillimetresPerInch * measured_in.minCoeff();
  const double highest_mm = kMillimetresPerInch * measured_in.maxCoeff();
  if (lowest_mm >= -kBeyond * stroke_mm && highest_mm <= (1.0 + kBeyond) * stroke_mm) return;
  throw DataError(fmt::format(
      "the rod of the record moves from {:.4g} to {:.4g} mm, and the simulated cylinder of the rig file only "
      "from 0 to {:g} mm: set stroke_mm, and the travel limits, in a copy of the rig file to those of your "
      "cylinder (a sensor whose 0 lies elsewhere needs its offset in the record), and name it with --rig",
      lowest_mm, highest_mm, stroke_mm));
}

/// What ends at a bound is not determined because the bound is too near. @throws DataError
void require_within_bounds(const std::vector<Coordinate>& coordinates, const Eigen::VectorXd& theta) {
  constexpr double kAtBound = 0.01;  // of the range
  constexpr double kWider = 10.0;
  for (std::size_t i = 0; i + 1 < coordinates.size(); ++i) {
    const Coordinate& c = coordinates[i];
    const double value = theta[static_cast<Eigen::Index>(i)];
    const double near = kAtBound * (c.high - c.low);
    if (value < c.high - near || !(c.high > 0.0)) continue;
    throw DataError(fmt::format("{0}: its value ends at its bound, {1:g}: give wider ones, as {0}={2:g}:{3:g}", c.key,
                                c.high, c.low, kWider * c.high));
  }
}

}  // namespace

Calibration calibrate(const hal::SimOptions& start, const std::vector<CalibrationRequest>& requests,
                      const Eigen::VectorXd& volts, const Eigen::VectorXd& measured_in, double step_s,
                      const ident::Executor& executor, const std::function<void(double, int)>& progress) {
  if (static_cast<double>(volts.size()) * step_s < kShortest_s) {
    throw DataError(fmt::format("expected at least {:g} s of record, got {:.3g} s", kShortest_s,
                                static_cast<double>(volts.size()) * step_s));
  }
  require_stroke(start, measured_in);
  const hal::SimOptions placed = starting_at(start, measured_in[0]);
  const Fit fit(placed, coordinates_for(placed, requests), volts, measured_in, step_s, executor);
  const auto count = static_cast<Eigen::Index>(fit.coordinates().size());
  Eigen::VectorXd theta(count);
  for (Eigen::Index i = 0; i + 1 < count; ++i) {
    theta[i] = value_of(placed, fit.coordinates()[static_cast<std::size_t>(i)].key);
  }
  theta[count - 1] = placed.initial_displacement_in;
  const Eigen::VectorXd before = theta;

  std::optional<Eigen::VectorXd> left = fit.residual(theta, fit.sub_step_us(theta));
  if (!left) throw ConfigError(to_lines(hal::check(placed), "sim"));
  Calibration result;
  double damping = kFirstDamping;
  Eigen::MatrixXd j = fit.jacobian(theta, *left);
  while (result.iterations < kMostIterations && !result.converged) {
    if (progress) progress(std::sqrt(left->squaredNorm() / static_cast<double>(left->size())), result.iterations);
    ++result.iterations;
    Eigen::MatrixXd normal = j.transpose() * j;
    const Eigen::VectorXd diagonal = normal.diagonal();
    normal.diagonal() += damping * diagonal.cwiseMax(1e-12 * diagonal.maxCoeff());
    const Eigen::VectorXd next = fit.moved(theta, ident::solve_symmetric(normal, j.transpose() * *left));
    const std::optional<Eigen::VectorXd> there = fit.residual(next, fit.sub_step_us(next));
    if (!there || there->squaredNorm() >= left->squaredNorm()) {
      damping *= 10.0;
      result.converged = damping > kMostDamping || (there && (next - theta).norm() < 1e-9 * theta.norm());
      continue;
    }
    const double gain = 1.0 - there->squaredNorm() / left->squaredNorm();
    theta = next;
    left = there;
    damping = std::max(damping * 0.1, 1e-9);
    result.converged = gain < kSmallestGain;
    j = fit.jacobian(theta, *left);
  }

  std::vector<std::string> names;
  for (const Coordinate& c : fit.coordinates()) names.push_back(c.key);
  const ident::ResidualModel residual = ident::residual_model(*left);
  const ident::Uncertainty known = ident::uncertainty(j, names, residual);
  require_within_bounds(fit.coordinates(), theta);
  require_determined(fit.coordinates(), j, known, residual);
  for (Eigen::Index i = 0; i + 1 < count; ++i) {
    const Coordinate& c = fit.coordinates()[static_cast<std::size_t>(i)];
    const double std = c.size * std::sqrt(known.covariance(i, i));
    result.parameters.push_back({c.key, before[i], theta[i], std, known.interval_factor * std});
  }
  // The intervals must also cover another integration step, and another machine.
  const std::optional<double> step_us = fit.sub_step_us(theta);
  if (const auto finer = fit.residual(theta, step_us ? std::optional(0.5 * *step_us) : step_us)) {
    const Eigen::VectorXd bias = ident::solve_symmetric(j.transpose() * j, j.transpose() * (*finer - *left));
    for (std::size_t i = 0; i < result.parameters.size(); ++i) {
      result.parameters[i].half_width += fit.coordinates()[i].size * std::abs(bias[static_cast<Eigen::Index>(i)]);
    }
  }
  result.options = fit.options(theta);
  result.options.sub_step_us = fit.sub_step_us(theta).value_or(start.sub_step_us);
  result.rms_error_in = std::sqrt(left->squaredNorm() / static_cast<double>(left->size()));
  const Eigen::VectorXd steps = left->tail(left->size() - 1) - left->head(left->size() - 1);
  result.noise_in = std::sqrt(0.5 * steps.squaredNorm() / static_cast<double>(steps.size()));
  return result;
}

}  // namespace eha::replay
