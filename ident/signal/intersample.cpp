// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/intersample.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "ident/signal/value_step.hpp"

namespace eha::ident {
namespace {

constexpr double kMovingRows = 0.7;        // share of all
constexpr double kMovingCoarseRows = 0.4;  // the same of a signal that its converter shows in single codes
constexpr double kGoingOn = 0.3;           // correlation of a row's movement with that of the row before
constexpr Eigen::Index kRowsBefore = 24;
constexpr Eigen::Index kPredictedRows = 2000;
constexpr double kFollows = 0.02;  // of the variance, left over by the rows before

/// Whether the rows before determine each row of an input, as of a sum of tones, however few rows their period has; not
/// the next level of a controller or a random one.
bool follows_from_rows_before(const Eigen::Ref<const Eigen::VectorXd>& input) {
  const Eigen::Index rows = std::min(kPredictedRows, input.size() - kRowsBefore);
  if (rows < 4 * kRowsBefore) return false;
  const Eigen::VectorXd centred = input.head(rows + kRowsBefore).array() - input.head(rows + kRowsBefore).mean();
  Eigen::MatrixXd before(rows, kRowsBefore);
  for (Eigen::Index lag = 0; lag < kRowsBefore; ++lag) before.col(lag) = centred.segment(lag, rows);
  const Eigen::VectorXd now = centred.tail(rows);
  const Eigen::VectorXd predicted = before * before.colPivHouseholderQr().solve(now);
  return (now - predicted).squaredNorm() < kFollows * now.squaredNorm();
}

/// Lagrange's cubic through y[-1], y[0], y[1], y[2] at x in 0..1.
double cubic(const double* y, double x) {
  return -x * (x - 1.0) * (x - 2.0) / 6.0 * y[-1] + (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0 * y[0] -
         (x + 1.0) * x * (x - 2.0) / 2.0 * y[1] + (x + 1.0) * x * (x - 1.0) / 6.0 * y[2];
}

/// The input between row k and the next, x of a row behind row k.
double between(const Eigen::VectorXd& input, Eigen::Index k, double x, Intersample intersample) {
  if (intersample == Intersample::held) return input[k];
  if (intersample == Intersample::straight) return input[k] + x * (input[k + 1] - input[k]);
  const Eigen::Index inner = std::clamp<Eigen::Index>(k, 1, input.size() - 3);
  return cubic(&input[inner], x + static_cast<double>(k - inner));
}

}  // namespace

Record in_parts(const Record& record, Intersample intersample) {
  const Eigen::Index rows = record.input.size();
  Record fine;
  fine.step_s = record.step_s / kPartsOfARow;
  fine.start_s = record.start_s;
  fine.input_channel = record.input_channel;
  fine.output_channel = record.output_channel;
  fine.parts = kPartsOfARow;
  fine.input.resize((rows - 1) * kPartsOfARow + 1);
  fine.output.resize(fine.input.size());
  for (Eigen::Index k = 0; k + 1 < rows; ++k) {
    const Eigen::Index inner = std::clamp<Eigen::Index>(k, 1, rows - 3);
    for (int part = 0; part < kPartsOfARow; ++part) {
      const double along = static_cast<double>(part) / kPartsOfARow;
      const Eigen::Index row = k * kPartsOfARow + part;
      fine.input[row] = between(record.input, k, along + 0.5 / kPartsOfARow, intersample);
      fine.output[row] =
          part == 0 ? record.output[k] : cubic(&record.output[inner], along + static_cast<double>(k - inner));
    }
  }
  fine.input.tail<1>() = record.input.tail<1>();
  fine.output.tail<1>() = record.output.tail<1>();
  // Those nearer to the row than to one beside it.
  constexpr auto kPartsOfIt = static_cast<Eigen::Index>((kPartsOfARow - 1) / 2);
  for (const std::size_t row : record.unmeasured) {
    const Eigen::Index at = static_cast<Eigen::Index>(row) * kPartsOfARow;
    for (Eigen::Index part = std::max<Eigen::Index>(0, at - kPartsOfIt);
         part <= std::min(at + kPartsOfIt, fine.input.size() - 1); ++part) {
      fine.unmeasured.push_back(static_cast<std::size_t>(part));
    }
  }
  return fine;
}

Eigen::VectorXd recorded_input(const Record& record) {
  if (record.parts == 1) return record.input;
  const auto every = [&](Eigen::Index first) {
    return record.input(Eigen::seq(first, Eigen::last - record.parts + first, record.parts));
  };
  Eigen::VectorXd recorded((record.input.size() - 1) / record.parts + 1);
  // The parts are at the middles between their rows.
  recorded.head(recorded.size() - 1) = every(0) - 0.5 * (every(1) - every(0));
  recorded.tail<1>() = record.input.tail<1>();
  return recorded;
}

double movement_within_half_a_row(const Eigen::Ref<const Eigen::VectorXd>& input) {
  if (input.size() < 4) return 0.0;
  const Eigen::VectorXd moved = input.tail(input.size() - 1) - input.head(input.size() - 1);
  const double spread = std::sqrt((input.array() - input.mean()).square().mean());
  const double energy = moved.squaredNorm();
  const auto moving = static_cast<double>((moved.array() != 0.0).count());
  const double going_on = moved.tail(moved.size() - 1).dot(moved.head(moved.size() - 1));
  const bool is_coarse = moves_by_single_steps({input.data(), static_cast<std::size_t>(input.size())});
  const double least_moving = is_coarse ? kMovingCoarseRows : kMovingRows;
  if (moving < least_moving * static_cast<double>(moved.size()) || !(spread > 0.0)) return 0.0;
  if (going_on < kGoingOn * energy && !follows_from_rows_before(input)) return 0.0;
  return 0.5 * std::sqrt(energy / static_cast<double>(moved.size())) / spread;
}

}  // namespace eha::ident
