// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/gain_change.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "ident/linear_algebra/least_squares_solvers.hpp"

namespace eha::ident {
namespace {

using Eigen::Index;

constexpr Index kFewestChanging = 200;  // samples
constexpr int kTimesTried = 100;        // of the record
constexpr int kBesideEnd = 8;           // of them at either end that are not tried
constexpr double kFarBetter = 0.4;      // of the squared error beside drifts
constexpr double kMostLeft = 0.1;       // of the output's variance, beside a change
constexpr double kLeastChange = 0.1;    // of the gain
constexpr double kLeastError = 0.02;    // of the output's standard deviation, which a change must make

/// GainSums of products of 1, the model's output and the measured one.
using GainSums = Eigen::Matrix3d;

/// What one gain and one offset leave over of the samples that the sums are of, squared, and that gain.
struct GainLine {
  double left = 0.0;
  double gain = 0.0;
};

GainLine gain_line_of(const GainSums& sums) {
  const double n = sums(0, 0);
  const double xx = sums(1, 1) - sums(0, 1) * sums(0, 1) / n;
  const double xy = sums(1, 2) - sums(0, 1) * sums(0, 2) / n;
  const double yy = sums(2, 2) - sums(0, 2) * sums(0, 2) / n;
  if (!(xx > 0.0)) return {std::max(0.0, yy), 0.0};
  return {std::max(0.0, yy - xy * xy / xx), xy / xx};
}

}  // namespace

std::optional<GainChange> gain_change(const Eigen::VectorXd& time_s, const Eigen::VectorXd& measured,
                                      const Eigen::VectorXd& simulated) {
  const Index n = measured.size();
  if (n < kFewestChanging || simulated.size() != n || time_s.size() != n || !measured.allFinite() ||
      !simulated.allFinite()) {
    return std::nullopt;
  }
  const Eigen::VectorXd y = measured.array() - measured.mean();
  const Eigen::VectorXd x = simulated.array() - simulated.mean();
  // Beside a drift of offset and gain.
  Eigen::MatrixXd drifts(n, 4);
  drifts.col(0).setOnes();
  drifts.col(1) = Eigen::VectorXd::LinSpaced(n, -1.0, 1.0);
  drifts.col(2) = x;
  drifts.col(3) = x.cwiseProduct(drifts.col(1));
  const Eigen::VectorXd solution = solve_symmetric(drifts.transpose() * drifts, drifts.transpose() * y);
  const double left_by_drifts = (y - drifts * solution).squaredNorm();
  const double least_error = kLeastError * kLeastError * y.squaredNorm();
  if (!(left_by_drifts > least_error)) return std::nullopt;
  std::array<GainSums, kTimesTried> parts;
  GainSums all = GainSums::Zero();
  const auto first_of = [&](int part) { return n * part / kTimesTried; };
  for (int part = 0; part < kTimesTried; ++part) {
    const Index first = first_of(part);
    const Index count = first_of(part + 1) - first;
    Eigen::MatrixXd columns(count, 3);
    columns << Eigen::VectorXd::Ones(count), x.segment(first, count), y.segment(first, count);
    parts[static_cast<std::size_t>(part)] = columns.transpose() * columns;
    all += parts[static_cast<std::size_t>(part)];
  }
  std::optional<GainChange> found;
  double least = std::min(kFarBetter * left_by_drifts, kMostLeft * y.squaredNorm());
  GainSums before = GainSums::Zero();
  for (int part = 0; part < kTimesTried - kBesideEnd; ++part) {
    before += parts[static_cast<std::size_t>(part)];
    if (part + 1 < kBesideEnd) continue;
    const GainLine early = gain_line_of(before);
    const GainLine late = gain_line_of(all - before);
    if (!(early.left + late.left < least) || !(early.gain > 0.0) || !(late.gain > 0.0)) continue;
    least = early.left + late.left;
    const double ratio = late.gain / early.gain;
    found.reset();
    if (std::abs(std::log(ratio)) > kLeastChange) found = GainChange{time_s[first_of(part + 1)], ratio};
  }
  return found;
}

OtherGain other_gain(const Eigen::VectorXd& measured, const Eigen::VectorXd& simulated) {
  const Eigen::VectorXd y = measured.array() - measured.mean();
  const Eigen::VectorXd x = simulated.array() - simulated.mean();
  const double ratio = x.squaredNorm() > 0.0 ? x.dot(y) / x.squaredNorm() : 1.0;
  return {ratio, std::sqrt((y - ratio * x).squaredNorm() / static_cast<double>(y.size()))};
}

}  // namespace eha::ident
