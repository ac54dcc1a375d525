// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/gain_change.hpp"

#include <Eigen/Cholesky>
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

/// Sums of products of 1, the time, the model's output and the measured one.
using GainSums = Eigen::Matrix4d;

/// Sums of squares and products of the model's output x and the measured y beside an offset, or a straight line.
struct BesideLine {
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;

  [[nodiscard]] double gain() const { return xx > 0.0 ? xy / xx : 0.0; }
  [[nodiscard]] double left() const { return std::max(0.0, yy - (xx > 0.0 ? xy * xy / xx : 0.0)); }
};

/// @param others  1: beside an offset; 2: beside a straight line
BesideLine beside(const GainSums& sums, Index others) {
  const Eigen::MatrixXd line = sums.topLeftCorner(others, others);
  const Eigen::MatrixXd both = sums.bottomLeftCorner(2, others);
  const Eigen::MatrixXd left = sums.bottomRightCorner<2, 2>() - both * line.ldlt().solve(both.transpose());
  return {left(0, 0), left(0, 1), left(1, 1)};
}

/// What is left over of two parts that have one gain.
double left_by_one_gain(const BesideLine& a, const BesideLine& b) {
  return BesideLine{a.xx + b.xx, a.xy + b.xy, a.yy + b.yy}.left();
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
    Eigen::MatrixXd columns(count, 4);
    columns << Eigen::VectorXd::Ones(count), drifts.col(1).segment(first, count), x.segment(first, count),
        y.segment(first, count);
    parts[static_cast<std::size_t>(part)] = columns.transpose() * columns;
    all += parts[static_cast<std::size_t>(part)];
  }
  const double most = std::min(kFarBetter * left_by_drifts, kMostLeft * y.squaredNorm());
  // What changes the gain of a rod may change its null, too, which then drifts at another rate; no change of the drift
  // alone may explain as much.
  for (const Index others : {1, 2}) {
    std::optional<GainChange> found;
    double least = most;
    GainSums before = GainSums::Zero();
    for (int part = 0; part < kTimesTried - kBesideEnd; ++part) {
      before += parts[static_cast<std::size_t>(part)];
      if (part + 1 < kBesideEnd) continue;
      const BesideLine early = beside(before, others);
      const BesideLine late = beside(all - before, others);
      const double left = early.left() + late.left();
      if (!(left < least) || !(early.gain() > 0.0) || !(late.gain() > 0.0)) continue;
      least = left;
      found.reset();
      if (others > 1 && !(left < kFarBetter * left_by_one_gain(early, late))) continue;
      const double ratio = late.gain() / early.gain();
      if (std::abs(std::log(ratio)) > kLeastChange) found = GainChange{time_s[first_of(part + 1)], ratio};
    }
    if (found) return found;
  }
  return std::nullopt;
}

OtherGain other_gain(const Eigen::VectorXd& measured, const Eigen::VectorXd& simulated) {
  const Eigen::VectorXd y = measured.array() - measured.mean();
  const Eigen::VectorXd x = simulated.array() - simulated.mean();
  const double ratio = x.squaredNorm() > 0.0 ? x.dot(y) / x.squaredNorm() : 1.0;
  return {ratio, std::sqrt((y - ratio * x).squaredNorm() / static_cast<double>(y.size()))};
}

}  // namespace eha::ident
