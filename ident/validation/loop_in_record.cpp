// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/loop_in_record.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/statistics/robust.hpp"

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
// Of a quiet loop. Smooth inputs that are read with noise or in steps, of plants that answer in the same row against
// their gain, reach a gain of 25 standard errors; loops that follow a reference have 30 and more.
constexpr int kTrims = 3;
constexpr double kFarFromMost = 4.0;        // standard deviations of most rows: a step of a reference or of a load
constexpr double kMostKept = 0.5;           // of the rows
constexpr double kLeastQuietInput = 3e-4;   // of the input's standard deviation: below, it is played and rounded
constexpr double kLeastOfMostRows = 0.7;    // of that deviation, of most rows: a played level is held in them
constexpr double kLeastQuietGain = 25.0;    // standard errors
constexpr double kNoQuietGain = 6.0;        // the same: below, the record has no answer of the plant to its input
constexpr double kLeastQuietNoise = 0.05;   // as kLeastLoopNoise
constexpr double kNoNoise = 1e-3;           // the same, where the noise alone goes round the loop
constexpr double kQuietAlone = -0.9;        // correlation of a loop without a gain
constexpr double kLeastQuietAnswer = 0.05;  // as kLeastLoopAnswer, of a loop without a gain

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

/// Beside a row of the input its own rows before, 1, and those of the noise.
Eigen::MatrixXd beside_past_of_noise(const Eigen::VectorXd& input, const Eigen::VectorXd& noise) {
  Eigen::MatrixXd both(noise.size() - kLoopOrder, 2 * kLoopOrder + 1);
  set_past(input, 0, both);
  both.col(kLoopOrder).setOnes();
  set_past(noise, kLoopOrder + 1, both);
  return both;
}

/// Of what the input does beside its own past, the share that the noise of the rows before explains. Such noise moves
/// the input of a loop only: a plant that answers in the same row, or to a long past, does not put it there.
double share_of_noise(const Eigen::VectorXd& input, const Eigen::VectorXd& noise) {
  const Eigen::MatrixXd both = beside_past_of_noise(input, noise);
  const double alone = left_over(both.leftCols<kLoopOrder + 1>(), input);
  return alone > 0.0 ? 1.0 - left_over(both, input) / alone : 0.0;
}

/// What moves output and input beside the rows before.
struct Moved {
  std::vector<Index> kept;  ///< rows that count
  Eigen::VectorXd output;   ///< of all rows
  Eigen::VectorXd input;
  Eigen::VectorXd of_rows_before;  ///< what the output takes of each column of the past
};

std::vector<Index> all_rows(Index count) {
  std::vector<Index> rows(static_cast<std::size_t>(count));
  std::iota(rows.begin(), rows.end(), Index{0});
  return rows;
}

/// @param kept  rows of `past` by which the answers are known
Moved moved_beside(const Eigen::MatrixXd& past, const Eigen::MatrixXd& now, std::vector<Index> kept) {
  const Eigen::MatrixXd last = now.bottomRows(past.rows());
  const Eigen::MatrixXd of_kept = past(kept, Eigen::all);
  const auto answer = [&](Index nth) {
    return solve_ranked(of_kept, Eigen::VectorXd(last.col(nth)(kept)), kLeastLoopPivot);
  };
  const Eigen::VectorXd of_output = answer(0);
  const Eigen::VectorXd of_input = answer(1);
  return {.kept = std::move(kept),
          .output = last.col(0) - past * of_output,
          .input = last.col(1) - past * of_input,
          .of_rows_before = of_output};
}

/// The rows in which neither signal moves far beyond what it does in most of them.
std::vector<Index> rows_without_steps(const Moved& moved) {
  const auto bound = [&](const Eigen::VectorXd& values) {
    return kFarFromMost * robust_std(std::vector<double>(values.begin(), values.end()));
  };
  const double most_output = bound(moved.output);
  const double most_input = bound(moved.input);
  std::vector<Index> rows;
  for (Index k = 0; k < moved.output.size(); ++k) {
    if (std::abs(moved.output[k]) <= most_output && std::abs(moved.input[k]) <= most_input) rows.push_back(k);
  }
  return rows;
}

/// share_of_noise() of the rows that count and have kLoopOrder such rows before them; 0 where they are few.
/// @param rows  receives how many they are
double share_of_noise_between_steps(const Eigen::VectorXd& input, const Moved& moved, const Eigen::VectorXd& noise,
                                    Index& rows) {
  std::vector<Index> counting;
  for (std::size_t nth = kLoopOrder; nth < moved.kept.size(); ++nth) {
    if (moved.kept[nth] - moved.kept[nth - kLoopOrder] == kLoopOrder) counting.push_back(moved.kept[nth] - kLoopOrder);
  }
  rows = static_cast<Index>(counting.size());
  if (rows < kFewestLoopRows) return 0.0;
  const Eigen::MatrixXd both = beside_past_of_noise(input, noise)(counting, Eigen::all);
  const Eigen::VectorXd wanted = input.tail(noise.size() - kLoopOrder)(counting);
  const double alone = left_over(both.leftCols<kLoopOrder + 1>(), wanted);
  return alone > 0.0 ? 1.0 - left_over(both, wanted) / alone : 0.0;
}

/// Gain of the plant in standard errors: the sum of what the output takes of the input's rows before.
/// @param gain  the sum
double gain_in_errors(const Eigen::MatrixXd& past, double gain, double squares_left) {
  Eigen::VectorXd of_gain = Eigen::VectorXd::Zero(past.cols());
  of_gain.segment<kLoopOrder>(kLoopOrder).setOnes();
  const double variance =
      of_gain.dot(solve_symmetric(past.transpose() * past, of_gain)) * squares_left / static_cast<double>(past.rows());
  return variance > 0.0 ? gain / std::sqrt(variance) : 0.0;
}

/// The correlation of a loop that makes much of the input.
std::optional<double> loud_loop(const Eigen::MatrixXd& past, const Eigen::MatrixXd& now) {
  const Index count = past.rows();
  const Moved moved = moved_beside(past, now, all_rows(count));
  const double of_output = moved.output.norm();
  const double of_input = moved.input.norm();
  if (!(of_output > 0.0) || of_input < kLeastLoopInput * std::sqrt(static_cast<double>(count))) return std::nullopt;
  const double correlation = moved.output.dot(moved.input) / (of_output * of_input);
  const double gain = moved.of_rows_before.segment(kLoopOrder, kLoopOrder).sum();
  const bool is_clear = std::abs(correlation) > kLeastLoopCorrelation &&
                        static_cast<double>(count) * correlation * correlation > kLeastLoopStrength;
  if (!is_clear || !(correlation * gain < 0.0)) return std::nullopt;
  if (!(std::abs(gain_in_errors(past, gain, of_output * of_output)) > kLeastLoopGain)) return std::nullopt;
  const Eigen::VectorXd noise = moved.output - moved.input * (correlation * of_output / of_input);
  if (!(noise.norm() > kLeastLoopNoise * of_output)) return std::nullopt;
  const double share = share_of_noise(now.col(1), noise);
  const bool is_answer =
      share > kLeastLoopAnswer && static_cast<double>(noise.size() - kLoopOrder) * share > kLeastLoopAnswers;
  return is_answer ? std::optional(correlation) : std::nullopt;
}

/// The same of the rows between the steps of a reference.
std::optional<LoopInRecord> quiet_loop(const Eigen::MatrixXd& past, const Eigen::MatrixXd& now) {
  Moved moved = moved_beside(past, now, all_rows(past.rows()));
  for (int trim = 0; trim < kTrims; ++trim) {
    std::vector<Index> kept = rows_without_steps(moved);
    if (static_cast<double>(kept.size()) < kMostKept * static_cast<double>(past.rows())) return std::nullopt;
    moved = moved_beside(past, now, std::move(kept));
  }
  const auto rows = static_cast<double>(moved.kept.size());
  const Eigen::VectorXd output = moved.output(moved.kept);
  const Eigen::VectorXd input = moved.input(moved.kept);
  const double of_output = output.norm();
  const double of_input = input.norm();
  if (!(of_output > 0.0) || of_input < kLeastQuietInput * std::sqrt(rows)) return std::nullopt;
  if (robust_std({input.begin(), input.end()}) < kLeastOfMostRows * of_input / std::sqrt(rows)) return std::nullopt;
  const double correlation = output.dot(input) / (of_output * of_input);
  if (!(rows * correlation * correlation > kLeastLoopStrength)) return std::nullopt;
  const double gain = moved.of_rows_before.segment(kLoopOrder, kLoopOrder).sum();
  const double errors = gain_in_errors(past(moved.kept, Eigen::all), gain, of_output * of_output);
  const Eigen::VectorXd noise = moved.output - moved.input * (correlation * of_output / of_input);
  const double noise_share = noise(moved.kept).norm() / of_output;
  const bool has_no_gain =
      std::abs(errors) < kNoQuietGain && correlation < kQuietAlone && of_input < kLeastLoopInput * std::sqrt(rows);
  if (has_no_gain && noise_share < kNoNoise) return LoopInRecord{correlation, false};
  const bool is_against_gain = correlation * errors < 0.0 && std::abs(errors) > kLeastQuietGain;
  const bool is_clear = std::abs(correlation) > kLeastLoopCorrelation && noise_share > kLeastQuietNoise;
  if (!is_clear || (!is_against_gain && !has_no_gain)) return std::nullopt;
  Index answering = 0;
  const double share = share_of_noise_between_steps(now.col(1), moved, noise, answering);
  const bool is_answer = share > (is_against_gain ? kLeastLoopAnswer : kLeastQuietAnswer) &&
                         static_cast<double>(answering) * share > kLeastLoopAnswers;
  return is_answer ? std::optional(LoopInRecord{correlation, is_against_gain}) : std::nullopt;
}

}  // namespace

std::optional<LoopInRecord> loop_in_record(const Record& record) {
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
  if (const std::optional<double> correlation = loud_loop(past, now)) return LoopInRecord{*correlation, false};
  return quiet_loop(past, now);
}

double same_row_correlation(const Record& record) {
  const Index rows = std::min(record.input.size(), record.output.size());
  const double correlation =
      scaled_signal(record.input.head(rows)).dot(scaled_signal(record.output.head(rows))) / static_cast<double>(rows);
  return std::isfinite(correlation) ? correlation : 0.0;
}

}  // namespace eha::ident
