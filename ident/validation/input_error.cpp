// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/input_error.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "ident/excitation/portable_draw.hpp"
#include "ident/fractional/stability.hpp"
#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/signal/fft.hpp"
#include "ident/signal/held_levels.hpp"
#include "ident/signal/intersample.hpp"
#include "ident/statistics/robust.hpp"

namespace eha::ident {
namespace {

constexpr double kMovingRows = 0.3;          // share of all; a command that is held moves in fewer
constexpr std::ptrdiff_t kLeastValues = 32;  // a staircase has fewer
constexpr double kSame = 1e-9;               // of the range: less is the conversion of decimals
constexpr double kLeastEnergy = 0.1;         // of the noise's variance
constexpr double kLeastFirst = 3.0;          // of the first column; less is no more than the noise has itself
constexpr Eigen::Index kMostColumns = 64;
constexpr double kRoughInput = 0.05;          // noise over the input's spread; more may be the excitation itself
constexpr double kMostNoise = 0.55;           // the same, of what may be noise beside rough excitation
constexpr double kFlatSpectrum = 0.2;         // of the logarithm of the power of two parts
constexpr Eigen::Index kPartsOfChanges = 50;  // of a record, over which changes are taken
constexpr int kDraws = 2;                     // of noise
constexpr std::uint64_t kSeed = 1;
constexpr double kShownShare = 0.4;                 // of the residual's power
constexpr double kNoPart = 0.02;                    // of the residual's share of the output, as a share of the input
constexpr double kMostShare = 2.5;                  // the same, by chance
constexpr double kOfRounding = 0.15;                // of the step: noise as great as that of rounding to it
constexpr double kSameNoise = 1.2;                  // ratio of two estimates of white noise
constexpr Eigen::Index kMostDifferences = 100'000;  // more do not sharpen the median
constexpr double kBeyondMean = 3.0;                 // of the length of z, which is sqrt(m) +- 0.7
constexpr Eigen::Index kBlock = 32;                 // rows that are looked for again
constexpr double kSameRows = 0.9;                   // share of all, one period apart
constexpr double kMostSamples = 3e7;                // of all columns' signals

/// The variance of a white noise beside which a slow walk does not show in the differences.
double white_variance(const Eigen::Ref<const Eigen::VectorXd>& residual) {
  const Eigen::Index rows = residual.size() - 1;
  return (residual.tail(rows) - residual.head(rows)).squaredNorm() / (2.0 * static_cast<double>(rows));
}

Eigen::VectorXd through_map(const Model& model, const Eigen::VectorXd& input) {
  return model.input_map ? mapped(*model.input_map, input) : input;
}

/// rounding_step() of the rows in the middle: enough of them show it, and a sort of all is dear.
double step_of_codes(const Eigen::Ref<const Eigen::VectorXd>& input) {
  const Eigen::Index rows = std::min(input.size(), kMostDifferences);
  return rounding_step(input.segment((input.size() - rows) / 2, rows));
}

/// The standard deviation of the white noise whose differences of an order are as great as those of the input.
/// @param step  of step_of_codes(): differences of codes are multiples of it, of which a median takes one; spread over
///              it they have a median that follows their spread
double difference_noise(const Eigen::Ref<const Eigen::VectorXd>& input, int order, double step) {
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(1);
  for (int k = 0; k < order; ++k) {
    Eigen::VectorXd next = Eigen::VectorXd::Zero(weights.size() + 1);
    next.tail(weights.size()) = weights;
    next.head(weights.size()) -= weights;
    weights = next;
  }
  const Eigen::Index every = 1 + input.size() / kMostDifferences;
  std::vector<double> differences;
  for (Eigen::Index k = 0; k + weights.size() <= input.size(); k += every) {
    differences.push_back(weights.dot(input.segment(k, weights.size())));
  }
  const double plain = robust_std(differences) / weights.norm();
  // Where most differences are 0 there is no noise to be spread.
  if (!(plain > 0.0) || !(step > 0.0)) return plain;
  double place = 0.0;
  for (double& difference : differences) {
    place += std::numbers::phi - 1.0;
    difference += step * (place - std::floor(place) - 0.5);
  }
  return robust_std(std::move(differences)) / weights.norm();
}

/// Whether the upper half of the spectrum is flat, as that of white noise beside a signal of lower frequencies; what a
/// lag makes of white noise still falls or rises there.
bool is_flat_above(const Eigen::Ref<const Eigen::VectorXd>& input) {
  const std::size_t length = std::max<std::size_t>(64, fast_length(static_cast<std::size_t>(input.size())));
  const RealFft transform(length);
  std::vector<double> signal(length, 0.0);
  const Eigen::Index rows = input.size();
  const double mean = input.mean();
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double window = std::sin(std::numbers::pi * (static_cast<double>(k) + 0.5) / static_cast<double>(rows));
    signal[static_cast<std::size_t>(k)] = window * window * (input[k] - mean);
  }
  std::vector<std::complex<double>> spectrum(transform.bins());
  transform.forward(signal, spectrum);
  const auto power = [&](double from, double to) {
    const auto first = static_cast<std::size_t>(from * static_cast<double>(transform.bins()));
    const auto last = static_cast<std::size_t>(to * static_cast<double>(transform.bins()));
    double sum = 0.0;
    for (std::size_t k = first; k < last; ++k) sum += std::norm(spectrum[k]);
    return sum / static_cast<double>(last - first);
  };
  const double ratio = power(0.5, 0.74) / power(0.75, 0.99);
  const double scatter = std::sqrt(2.0 * 1.94 / (0.24 * static_cast<double>(rows) / 2.0));  // of a windowed spectrum
  return std::abs(std::log(ratio)) < std::min(kFlatSpectrum, 3.0 * scatter);
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

/// The white noise that an input shows in its differences, of at most a share of its spread; none where it shows none.
std::optional<double> white_part(const Eigen::Ref<const Eigen::VectorXd>& input, double most) {
  if (input.size() < kLeastValues) return std::nullopt;
  // Most differences of a held input are its noise, those of a smooth one are not.
  const double step = step_of_codes(input);
  const double held = difference_noise(input, 1, step);
  const double fourth = difference_noise(input, 4, step);
  const double sixth = difference_noise(input, 6, step);
  const double spread = std::sqrt((input.array() - input.mean()).square().mean());
  if (!(sixth > 0.0) || fourth > most * spread) return std::nullopt;
  if (held < kSameNoise * fourth) return held;
  return fourth < kSameNoise * sixth ? std::optional(sixth) : std::nullopt;
}

/// An input at the recorded rows, in the parts of a record. Behind the last recorded row, where a record was cut, it is
/// the record's own.
Eigen::VectorXd between_rows_of(const Record& record, const Eigen::VectorXd& recorded, Intersample way) {
  if (record.parts == 1) return recorded;
  Record rows;
  rows.input = recorded;
  rows.output = recorded;
  const Eigen::VectorXd made = in_parts(rows, way).input;
  Eigen::VectorXd found = record.input;
  const Eigen::Index known = std::min(found.size(), made.size());
  found.head(known) = made.head(known);
  return found;
}

double spread_of(const Eigen::VectorXd& signal) { return std::sqrt((signal.array() - signal.mean()).square().mean()); }

/// Mean square of the changes over so many rows.
double power_of_changes(const Eigen::VectorXd& signal, Eigen::Index lag) {
  const Eigen::Index rows = signal.size() - lag;
  return (signal.tail(rows) - signal.head(rows)).squaredNorm() / static_cast<double>(rows);
}

/// A gap of the record with a straight line as its input.
struct Line {
  Eigen::Index first = 0;
  Eigen::Index rows = 0;
  double change = 0.0;  ///< across it
};

std::vector<Line> lines_across_gaps(const Record& record) {
  const Eigen::VectorXd& input = record.input;
  const std::vector<std::size_t>& unmeasured = record.unmeasured;
  const double same = kSame * (input.maxCoeff() - input.minCoeff());
  std::vector<Line> lines;
  for (std::size_t i = 0; i < unmeasured.size();) {
    std::size_t end = i + 1;
    while (end < unmeasured.size() && unmeasured[end] == unmeasured[end - 1] + 1) ++end;
    const auto first = static_cast<Eigen::Index>(unmeasured[i]);
    const auto rows = static_cast<Eigen::Index>(end - i);
    i = end;
    if (first == 0 || first + rows >= input.size()) continue;
    const double from = input[first - 1];
    const double change = input[first + rows] - from;
    // An input that was measured lies on no line but one that does not rise.
    const Eigen::ArrayXd line = Eigen::ArrayXd::LinSpaced(rows + 2, from, from + change).segment(1, rows);
    const bool is_line = (input.segment(first, rows).array() - line).abs().maxCoeff() <= same;
    if (is_line && std::abs(change) > same) lines.push_back({first, rows, change});
  }
  return lines;
}

/// How far a line across one measured row errs, over half the change across it; at most 1, as of a staircase.
double error_of_lines(const Record& record) {
  const Eigen::VectorXd& u = record.input;
  const Eigen::Index rows = u.size() - 2;
  if (rows < 1) return 0.0;
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(u.size());
  for (const std::size_t row : record.unmeasured) weights[static_cast<Eigen::Index>(row)] = 0.0;
  const Eigen::ArrayXd known =
      weights.head(rows).array() * weights.segment(1, rows).array() * weights.tail(rows).array();
  const Eigen::ArrayXd half = 0.5 * (u.tail(rows) - u.head(rows)).array();
  const Eigen::ArrayXd error = (u.segment(1, rows) - 0.5 * (u.tail(rows) + u.head(rows))).array();
  const double changes = (known * half.square()).sum();
  return changes > 0.0 ? std::min(1.0, std::sqrt((known * error.square()).sum() / changes)) : 0.0;
}

}  // namespace

double rounding_step(const Eigen::Ref<const Eigen::VectorXd>& input) {
  if (input.size() < kLeastValues) return 0.0;
  const Eigen::Index rows = input.size() - 1;
  const double same = kSame * (input.maxCoeff() - input.minCoeff());
  const auto moving = static_cast<double>(((input.tail(rows) - input.head(rows)).array().abs() > same).count());
  if (moving < kMovingRows * static_cast<double>(rows)) return 0.0;
  Eigen::VectorXd values = input;
  std::sort(values.begin(), values.end());
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

double white_noise(const Eigen::Ref<const Eigen::VectorXd>& signal) {
  return white_part(signal, kRoughInput).value_or(0.0);
}

double apparent_input_noise(const Eigen::Ref<const Eigen::VectorXd>& input) {
  const double noise = white_part(input, kMostNoise).value_or(0.0);
  if (!(noise > 0.0)) return 0.0;
  // Between the switches of a held input nothing but noise is left.
  const double step = step_of_codes(input);
  const bool is_held = difference_noise(input, 1, step) < kSameNoise * difference_noise(input, 4, step);
  return is_held || is_flat_above(input) ? noise : 0.0;
}

double input_error_std(const Eigen::Ref<const Eigen::VectorXd>& input) {
  return std::max(rounding_step(input) * std::sqrt(repetitions(input) / 12.0), white_noise(input));
}

Eigen::MatrixXd input_walk(const Model& model, OutputOnRecord& outputs, Eigen::Index first,
                           const Eigen::Ref<const Eigen::VectorXd>& residual, double error_std) {
  const Eigen::Index rows = static_cast<Eigen::Index>(outputs.comparison().count) - first;
  Eigen::MatrixXd walk(rows, 0);
  const Eigen::Index known = std::min(rows, residual.size());
  if (!(error_std > 0.0) || known < 2 || grows(model.transfer_function)) return walk;
  const Eigen::VectorXd& input = outputs.record().input;
  const auto samples = static_cast<double>(input.size());
  const double scale = error_std * std::sqrt(2.0 / samples);
  const double noise = white_variance(residual.tail(known));
  if (!(noise > 0.0)) return walk;
  const auto angle = Eigen::ArrayXd::LinSpaced(input.size(), 0.5, samples - 0.5) * std::numbers::pi / samples;
  const Eigen::Index most = std::min(kMostColumns, static_cast<Eigen::Index>(kMostSamples / samples));
  for (Eigen::Index k = 0; k < most; ++k) {
    // One signal at a time, for each may have 10^7 rows.
    Eigen::VectorXd passed = (k == 0 ? std::sqrt(0.5) : 1.0) * scale * (static_cast<double>(k) * angle).cos();
    if (model.input_map) passed = through_map(model, input + passed) - through_map(model, input);
    const Eigen::VectorXd column = outputs.response(model.transfer_function, passed).tail(rows);
    const double energy = (column.array() - column.mean()).square().sum();
    if (!(energy >= (k == 0 ? kLeastFirst : kLeastEnergy) * noise)) break;
    walk.conservativeResize(Eigen::NoChange, k + 1);
    walk.col(k) = column;
  }
  return walk;
}

Eigen::VectorXd beyond_errors(const Eigen::VectorXd& residual, const Eigen::MatrixXd& errors) {
  if (errors.cols() == 0) return residual;
  Eigen::MatrixXd normal = errors.transpose() * errors;
  normal.diagonal().array() += white_variance(residual);
  const Eigen::VectorXd z = solve_symmetric(normal, errors.transpose() * residual);
  const double longest = std::sqrt(static_cast<double>(errors.cols())) + kBeyondMean;
  return residual - std::min(1.0, longest / std::max(z.norm(), longest)) * (errors * z);
}

Eigen::MatrixXd channel_noise(const Model& model, OutputOnRecord& outputs, const SignalFacts& facts,
                              Eigen::Index first) {
  const Eigen::Index rows = static_cast<Eigen::Index>(outputs.comparison().count) - first;
  const Eigen::VectorXd& input = outputs.record().input;
  if (grows(model.transfer_function) || !facts.held_levels()) return Eigen::MatrixXd(rows, 0);
  const Eigen::VectorXd& levels = *facts.held_levels();
  return outputs.response(model.transfer_function, through_map(model, input) - through_map(model, levels)).tail(rows);
}

std::optional<InputNoise> input_noise_left_over(const Model& model, OutputOnRecord& outputs, const SignalFacts& facts,
                                                const Eigen::VectorXd& residual) {
  const Record& record = outputs.record();
  const Eigen::Index lag = residual.size() / kPartsOfChanges;
  if (lag < 1 || grows(model.transfer_function)) return std::nullopt;
  const double rms = facts.apparent_input_noise();
  if (!(rms > 0.0)) return std::nullopt;
  const Eigen::VectorXd recorded = recorded_input(record);
  // As the last digit of a file makes it: far too little beside what is left over, whatever the plant does to it.
  const double left_over = residual.norm() / std::sqrt(static_cast<double>(residual.size()));
  if (rms * spread_of(record.output) < kNoPart * left_over * spread_of(recorded)) return std::nullopt;
  const double step = step_of_codes(recorded);
  const Eigen::VectorXd driven = through_map(model, record.input);
  const auto of_model = [&](const Eigen::VectorXd& signal) {
    return outputs.measured_rows().of(outputs.response(model.transfer_function, signal));
  };
  PortableDraw draw(kSeed);
  double made = 0.0;
  Eigen::VectorXd noisy(recorded.size());
  for (int k = 0; k < kDraws; ++k) {
    for (Eigen::Index row = 0; row < recorded.size(); ++row) noisy[row] = recorded[row] + rms * draw.normal();
    const Eigen::VectorXd input = between_rows_of(record, noisy, Intersample::straight);
    made += power_of_changes(of_model(through_map(model, input) - driven), lag) / kDraws;
  }
  const double left = power_of_changes(residual, lag);
  const double whole = power_of_changes(of_model(driven.array() - driven.mean()), lag);
  const bool is_rounding = std::abs(rms * std::sqrt(12.0) - step) < kOfRounding * step;
  const InputNoise found{rms, std::sqrt(0.5 * made), made / left, whole > made ? made / (whole - made) : 1.0,
                         is_rounding ? step : 0.0};
  return found.share >= kShownShare && found.share <= kMostShare ? std::optional(found) : std::nullopt;
}

std::optional<double> curves_between_rows(const Model& model, OutputOnRecord& outputs) {
  const Record& record = outputs.record();
  if (record.parts == 1 || grows(model.transfer_function)) return std::nullopt;
  const Eigen::VectorXd curves = between_rows_of(record, recorded_input(record), Intersample::smooth);
  const Eigen::VectorXd change = through_map(model, curves) - through_map(model, record.input);
  const Eigen::VectorXd made = outputs.measured_rows().of(outputs.response(model.transfer_function, change));
  // A plant that integrates adds up the least mean, which is no error of the lines.
  const Eigen::VectorXd line = Eigen::VectorXd::LinSpaced(made.size(), -1.0, 1.0);
  const Eigen::VectorXd about = made.array() - made.mean();
  return std::sqrt((about - line * (line.dot(about) / line.squaredNorm())).squaredNorm() /
                   static_cast<double>(made.size()));
}

Eigen::MatrixXd guessed_switches(const Model& model, OutputOnRecord& outputs, Eigen::Index first,
                                 const Eigen::Ref<const Eigen::VectorXd>& residual) {
  const Eigen::Index rows = static_cast<Eigen::Index>(outputs.comparison().count) - first;
  const Record& record = outputs.record();
  Eigen::MatrixXd found(rows, 0);
  if (record.unmeasured.empty() || rows < 2 || residual.size() < rows || grows(model.transfer_function)) return found;
  std::vector<Line> lines = lines_across_gaps(record);
  std::stable_sort(lines.begin(), lines.end(),
                   [](const Line& a, const Line& b) { return std::abs(a.change) > std::abs(b.change); });
  const double error = error_of_lines(record);
  const double noise = white_variance(residual.tail(rows));
  const Eigen::VectorXd driven = through_map(model, record.input);
  for (const Line& line : lines) {
    if (found.cols() == kMostColumns) break;
    Eigen::VectorXd other = record.input;
    for (Eigen::Index k = 0; k < line.rows; ++k) {
      const double share = static_cast<double>(k + 1) / static_cast<double>(line.rows + 1);
      other[line.first + k] += error * std::sqrt(share * (1.0 - share)) * line.change;
    }
    const Eigen::VectorXd column =
        outputs.response(model.transfer_function, through_map(model, other) - driven).tail(rows);
    if (!(column.squaredNorm() >= kLeastEnergy * noise)) continue;
    found.conservativeResize(Eigen::NoChange, found.cols() + 1);
    found.rightCols<1>() = column;
  }
  return found;
}

}  // namespace eha::ident
