// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/input_rounding.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "ident/fractional/stability.hpp"
#include "ident/signal/held_levels.hpp"

namespace eha::ident {
namespace {

constexpr double kMovingRows = 0.3;          // share of all; a command that is held moves in fewer
constexpr std::ptrdiff_t kLeastValues = 32;  // a staircase has fewer
constexpr double kSame = 1e-9;               // of the range: less is the conversion of decimals
constexpr double kLeastEnergy = 0.1;         // of the noise's variance
constexpr double kLeastFirst = 3.0;          // of the first column; less is no more than the noise has itself
constexpr Eigen::Index kMostColumns = 64;
constexpr Eigen::Index kBlock = 32;   // rows that are looked for again
constexpr double kSameRows = 0.9;     // share of all, one period apart
constexpr double kMostSamples = 3e7;  // of all columns' signals

/// The variance of a white noise beside which a slow walk does not show in the differences.
double white_variance(const Eigen::Ref<const Eigen::VectorXd>& residual) {
  const Eigen::Index rows = residual.size() - 1;
  return (residual.tail(rows) - residual.head(rows)).squaredNorm() / (2.0 * static_cast<double>(rows));
}

/// How many times the same values are played, whose rounding then is the same; 1 if they do not repeat.
double repetitions(const Eigen::Ref<const Eigen::VectorXd>& input) {
  const Eigen::Index middle = input.size() / 2;
  if (input.size() < 4 * kBlock) return 1.0;
  const auto again = std::search(input.begin() + middle + kBlock / 2, input.end(), input.begin() + middle,
                                 input.begin() + middle + kBlock);
  const Eigen::Index period = again - (input.begin() + middle);
  if (again == input.end() || 2 * period > input.size()) return 1.0;
  const Eigen::Index rows = input.size() - period;
  const auto same = static_cast<double>((input.head(rows).array() == input.tail(rows).array()).count());
  return same < kSameRows * static_cast<double>(rows) ? 1.0
                                                      : static_cast<double>(input.size()) / static_cast<double>(period);
}

}  // namespace

double rounding_step(const Eigen::Ref<const Eigen::VectorXd>& input) {
  if (input.size() < kLeastValues) return 0.0;
  const Eigen::Index rows = input.size() - 1;
  const auto moving = static_cast<double>((input.tail(rows).array() != input.head(rows).array()).count());
  if (moving < kMovingRows * static_cast<double>(rows)) return 0.0;
  Eigen::VectorXd values = input;
  std::sort(values.begin(), values.end());
  const double same = kSame * (values[rows] - values[0]);
  double step = std::numeric_limits<double>::infinity();
  std::ptrdiff_t count = 1;
  for (Eigen::Index k = 1; k <= rows; ++k) {
    const double difference = values[k] - values[k - 1];
    if (difference <= same) continue;
    step = std::min(step, difference);
    ++count;
  }
  return count < kLeastValues ? 0.0 : step;
}

Eigen::MatrixXd rounding_walk(const Model& model, OutputOnRecord& outputs, Eigen::Index first,
                              const Eigen::Ref<const Eigen::VectorXd>& residual) {
  const Eigen::Index rows = static_cast<Eigen::Index>(outputs.comparison().count) - first;
  Eigen::MatrixXd walk(rows, 0);
  if (rows < 2 || residual.size() < rows || grows(model.transfer_function)) return walk;
  const Eigen::VectorXd& input = outputs.record().input;
  const auto samples = static_cast<double>(input.size());
  const double scale = rounding_step(input) / std::sqrt(12.0) * std::sqrt(2.0 / samples * repetitions(input));
  const double noise = white_variance(residual.tail(rows));
  if (!(scale > 0.0) || !(noise > 0.0)) return walk;
  const Eigen::ArrayXd angle =
      (Eigen::ArrayXd::LinSpaced(input.size(), 0.5, samples - 0.5) * std::numbers::pi / samples);
  const Eigen::Index most = std::min(kMostColumns, static_cast<Eigen::Index>(kMostSamples / samples));
  for (Eigen::Index k = 0; k < most; ++k) {
    const Eigen::VectorXd wave = (k == 0 ? std::sqrt(0.5) : 1.0) * scale * (static_cast<double>(k) * angle).cos();
    const Eigen::VectorXd column = outputs.response(model.transfer_function, wave).tail(rows);
    const double energy = (column.array() - column.mean()).square().sum();
    if (!(energy >= (k == 0 ? kLeastFirst : kLeastEnergy) * noise)) break;
    walk.conservativeResize(Eigen::NoChange, k + 1);
    walk.col(k) = column;
  }
  return walk;
}

Eigen::MatrixXd channel_noise(const Model& model, OutputOnRecord& outputs, Eigen::Index first) {
  const Eigen::Index rows = static_cast<Eigen::Index>(outputs.comparison().count) - first;
  const Eigen::VectorXd& input = outputs.record().input;
  const Eigen::VectorXd levels = held_levels(input);
  if (grows(model.transfer_function) || levels == input) return Eigen::MatrixXd(rows, 0);
  const auto through_map = [&](const Eigen::VectorXd& u) { return model.input_map ? mapped(*model.input_map, u) : u; };
  return outputs.response(model.transfer_function, through_map(input) - through_map(levels)).tail(rows);
}

}  // namespace eha::ident
