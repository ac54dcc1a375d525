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
constexpr double kLeastLoopGain = 5.0;       // standard errors of the plant's gain
// Of what the input does beside its own past, the share that answers the noise of the rows before. Plants that answer
// in the same row reach 0.006; loops with a reference have 0.01 and more.
constexpr double kLeastLoopAnswer = 0.01;
constexpr double kLeastLoopAnswers = 45.0;  // rows times that share, which chance exceeds once in 10^7
constexpr double kLeastLoopPivot = 1e-8;    // below which rows of a plant without noise repeat one another
constexpr double kLeastLoopNoise = 0.01;    // of what moves the output, without the part that the input has in it

Eigen::VectorXd scaled_signal(const Eigen::VectorXd& signal) {
  const Eigen::VectorXd centred = signal.array() - signal.mean();
  const double deviation = std::sqrt(centred.squaredNorm() / static_cast<double>(centred.size()));
  return deviation > 0.0 ? Eigen::VectorXd(centred / deviation) : centred;
}

/// Sets the columns of `past` from the nth to the values of a signal 1 .. kLoopOrder rows before each of its rows.
void set_past(const Eigen::VectorXd& signal, Index nth, Eigen::MatrixXd& past) {
  const Index first = signal.size() - past.rows();
  for (Index lag = 1; lag <= kLoopOrder; ++lag) past.col(nth + lag - 1) = signal.segment(first - lag, past.rows());
}

/// What its columns do not explain of a signal's last rows: the sum of squares.
double left_over(const Eigen::MatrixXd& columns, const Eigen::VectorXd& signal) {
  const Eigen::VectorXd last = signal.tail(columns.rows());
  return (last - columns * solve_ranked(columns, last, kLeastLoopPivot)).squaredNorm();
}

/// Of what the input does beside its own past, the share that the noise of the rows before explains. Such noise moves
/// the input of a loop only: a plant that answers in the same row, or to a long past, does not put it there.
double share_of_noise(const Eigen::VectorXd& input, const Eigen::VectorXd& noise) {
  const Index rows = noise.size() - kLoopOrder;
  Eigen::MatrixXd past(rows, kLoopOrder + 1);
  past.rightCols<1>().setOnes();
  set_past(input, 0, past);
  Eigen::MatrixXd both(rows, 2 * kLoopOrder + 1);
  both.leftCols<kLoopOrder + 1>() = past;
  set_past(noise, kLoopOrder + 1, both);
  const double alone = left_over(past, input);
  return alone > 0.0 ? 1.0 - left_over(both, input) / alone : 0.0;
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
  set_past(now.col(0), 0, past);
  set_past(now.col(1), kLoopOrder, past);
  Eigen::MatrixXd answers(past.cols(), 2);
  for (Index nth = 0; nth < 2; ++nth) {
    answers.col(nth) = solve_ranked(past, now.col(nth).tail(count), kLeastLoopPivot);
  }
  const Eigen::MatrixXd moved = now.bottomRows(count) - past * answers;
  const double of_output = moved.col(0).norm();
  const double of_input = moved.col(1).norm();
  if (!(of_output > 0.0) || of_input < kLeastLoopInput * std::sqrt(static_cast<double>(count))) return std::nullopt;
  const double correlation = moved.col(0).dot(moved.col(1)) / (of_output * of_input);
  const double gain = answers.col(0).segment(kLoopOrder, kLoopOrder).sum();
  const bool is_clear = std::abs(correlation) > kLeastLoopCorrelation &&
                        static_cast<double>(count) * correlation * correlation > kLeastLoopStrength;
  if (!is_clear || !(correlation * gain < 0.0)) return std::nullopt;
  Eigen::VectorXd of_gain = Eigen::VectorXd::Zero(2 * kLoopOrder + 1);
  of_gain.segment<kLoopOrder>(kLoopOrder).setOnes();
  const double variance = of_gain.dot(solve_symmetric(past.transpose() * past, of_gain)) * moved.col(0).squaredNorm() /
                          static_cast<double>(count);
  if (!(variance > 0.0) || !(gain * gain > kLeastLoopGain * kLeastLoopGain * variance)) return std::nullopt;
  const Eigen::VectorXd noise = moved.col(0) - moved.col(1) * (correlation * of_output / of_input);
  if (!(noise.norm() > kLeastLoopNoise * of_output)) return std::nullopt;
  const double share = share_of_noise(now.col(1), noise);
  const bool is_answer =
      share > kLeastLoopAnswer && static_cast<double>(noise.size() - kLoopOrder) * share > kLeastLoopAnswers;
  return is_answer ? std::optional(correlation) : std::nullopt;
}

double same_row_correlation(const Record& record) {
  const Index rows = std::min(record.input.size(), record.output.size());
  const double correlation =
      scaled_signal(record.input.head(rows)).dot(scaled_signal(record.output.head(rows))) / static_cast<double>(rows);
  return std::isfinite(correlation) ? correlation : 0.0;
}

}  // namespace eha::ident
