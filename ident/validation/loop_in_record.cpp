// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/loop_in_record.hpp"

#include <algorithm>
#include <cmath>

#include "ident/linear_algebra/least_squares_solvers.hpp"

namespace eha::ident {
namespace {

using Eigen::Index;

constexpr Index kLoopOrder = 6;
constexpr Index kFewestLoopRows = 200;
constexpr Index kMostLoopRows = 20'000;
// Open-loop records, thinned, filtered and of plants that are not linear among them, reach 0.05, or have a smooth
// input.
constexpr double kLeastLoopCorrelation = 0.3;
constexpr double kLeastLoopStrength = 30.0;  // rows times the squared correlation, which chance exceeds once in 10^7
constexpr double kLeastLoopInput = 0.2;      // of the input's standard deviation

Eigen::VectorXd scaled_signal(const Eigen::VectorXd& signal) {
  const Eigen::VectorXd centred = signal.array() - signal.mean();
  const double deviation = std::sqrt(centred.squaredNorm() / static_cast<double>(centred.size()));
  return deviation > 0.0 ? Eigen::VectorXd(centred / deviation) : centred;
}

}  // namespace

std::optional<double> loop_in_record(const Record& record) {
  const Index rows = std::min({record.input.size(), record.output.size(), kMostLoopRows});
  if (rows < kFewestLoopRows) return std::nullopt;
  Eigen::MatrixXd now(rows, 2);
  now << scaled_signal(record.output.head(rows)), scaled_signal(record.input.head(rows));
  if (!now.allFinite()) return std::nullopt;
  const Index count = rows - kLoopOrder;
  Eigen::MatrixXd past(count, 2 * kLoopOrder + 1);
  past.rightCols<1>().setOnes();
  for (Index lag = 1; lag <= kLoopOrder; ++lag) {
    past.col(lag - 1) = now.col(0).segment(kLoopOrder - lag, count);
    past.col(kLoopOrder + lag - 1) = now.col(1).segment(kLoopOrder - lag, count);
  }
  const Eigen::MatrixXd answers = solve_pivoted(past, now.bottomRows(count));
  const Eigen::MatrixXd moved = now.bottomRows(count) - past * answers;
  const double of_output = moved.col(0).norm();
  const double of_input = moved.col(1).norm();
  if (!(of_output > 0.0) || of_input < kLeastLoopInput * std::sqrt(static_cast<double>(count))) return std::nullopt;
  const double correlation = moved.col(0).dot(moved.col(1)) / (of_output * of_input);
  const double gain = answers.col(0).segment(kLoopOrder, kLoopOrder).sum();
  const bool is_against = correlation * gain < 0.0;
  const bool is_clear = std::abs(correlation) > kLeastLoopCorrelation &&
                        static_cast<double>(count) * correlation * correlation > kLeastLoopStrength;
  return is_against && is_clear ? std::optional(correlation) : std::nullopt;
}

}  // namespace eha::ident
