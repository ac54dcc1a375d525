// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/lone_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/time_text.hpp"
#include "daemon/importer/signal_scale.hpp"
#include "ident/signal/value_step.hpp"

namespace eha::importer {
namespace {

constexpr std::size_t kFewestWithLone = 60;
constexpr std::size_t kMostTogether = 3;
constexpr double kOverUsual = 30.0;      // distance over the usual one of a row from the middle of its neighbours
constexpr double kOverSteps = 2.5;       // distance over the step of a coarse sensor, which noise alone may cross
constexpr double kOverRange = 0.03;      // distance over the range of the output
constexpr double kNeighboursOff = 0.1;   // difference of the neighbours over the distance
constexpr double kBeyondRange = 1.5;     // distance of rows that no signal of this range reaches, over it
constexpr double kMostShare = 0.05;      // of the rows
constexpr double kInputOverRange = 2.0;  // of a lone input
constexpr std::size_t kFrozen = 50;      // equal rows that show nothing of a signal's noise
constexpr std::size_t kInputBefore = 5;  // rows in which the input may be the cause
constexpr double kStepOverUsual = 10.0;  // change of an input that steps, over the usual one
constexpr double kStepOverRange = 0.02;  // ... over its range
constexpr double kOverAnswers = 3.0;     // distance a volt of the step, over the motions after the others

/// The values without those that repeat kFrozen and more times in a row.
std::vector<double> without_frozen(std::span<const double> values) {
  std::vector<double> moving;
  moving.reserve(values.size());
  for (std::size_t from = 0; from < values.size();) {
    std::size_t to = from + 1;
    while (to < values.size() && values[to] == values[from]) ++to;
    if (to - from < kFrozen) moving.insert(moving.end(), to - from, values[from]);
    from = to;
  }
  return moving;
}

/// Whether rows from .. from + count - 1 lie apart from both neighbours, which agree.
bool stands_alone(std::span<const double> y, std::size_t from, std::size_t count, const Scale& scale) {
  const std::size_t next = from + count;
  const double before = y[from - 1];
  const double after = y[next];
  const double slope = (after - before) / static_cast<double>(count + 1);
  double distance = std::numeric_limits<double>::infinity();
  for (std::size_t k = from; k < next; ++k) {
    distance = std::min(distance, std::abs(y[k] - before - slope * static_cast<double>(k + 1 - from)));
  }
  const double off = std::abs(after - before);
  return std::isfinite(distance) && distance > kOverSteps * scale.step && distance > kOverUsual * scale.usual &&
         distance > kOverRange * scale.range && off < kNeighboursOff * distance;
}

/// Whether rows from .. from + count - 1 are the turning point of a motion: one that came before goes on into them, or
/// the one out of them goes on, at no more than twice its pace.
bool continues_a_motion(std::span<const double> y, std::size_t from, std::size_t count) {
  constexpr double kPace = 2.0;
  const auto goes_on = [](double slower, double faster) {
    return slower * faster > 0.0 && std::abs(faster) < kPace * std::abs(slower);
  };
  const std::size_t last = from + count - 1;
  return (from >= 2 && goes_on(y[from - 1] - y[from - 2], y[from] - y[from - 1])) ||
         (last + 2 < y.size() && goes_on(y[last + 2] - y[last + 1], y[last + 1] - y[last]));
}

/// How many rows from `from` on lie beyond all the others, reached and left within one row: the value that a sensor or
/// its converter gives in the place of a reading. At most a hundredth of the rows; 0: none.
std::size_t rows_beyond(std::span<const double> y, std::size_t from, const Scale& scale) {
  const double least = kBeyondRange * scale.range;
  const std::size_t most = y.size() / 100;
  const auto is_beyond = [&](std::size_t k) { return std::abs(y[k] - y[from - 1]) > least; };
  if (!(least > 0.0) || !is_beyond(from)) return 0;
  std::size_t next = from + 1;
  while (next < y.size() && next - from <= most && is_beyond(next)) ++next;
  const bool comes_back = next < y.size() && next - from <= most && std::abs(y[next] - y[from - 1]) < scale.range;
  return comes_back ? next - from : 0;
}

/// Where an input steps, and how far the output moves in one row soon afterwards.
class Steps {
 public:
  Steps(std::span<const double> input, std::span<const double> output) {
    std::vector<double> changes;
    for (std::size_t k = 1; k < input.size(); ++k) changes.push_back(std::abs(input[k] - input[k - 1]));
    if (changes.empty()) return;
    const double least = std::max(kStepOverUsual * quantile(changes, 0.5), kStepOverRange * scale_of(input).range);
    for (std::size_t k = 1; k < input.size(); ++k) {
      if (!(changes[k - 1] > least)) continue;
      double most = 0.0;
      for (std::size_t j = k; j < std::min(k + kMoved, output.size()); ++j) {
        most = std::max(most, std::abs(output[j] - output[j - 1]));
      }
      rows_.push_back(k);
      motions_.push_back(most / changes[k - 1]);
    }
    if (rows_.size() >= kFewestSteps) usual_ = quantile(motions_, kMostSteps);
    greatest_to_ = motions_;
    greatest_from_ = motions_;
    for (std::size_t i = 1; i < motions_.size(); ++i) {
      greatest_to_[i] = std::max(greatest_to_[i], greatest_to_[i - 1]);
      const std::size_t k = motions_.size() - 1 - i;
      greatest_from_[k] = std::max(greatest_from_[k], greatest_from_[k + 1]);
    }
  }

  /// Whether a step within or just before these rows may have caused them: the output moves as far a volt after the
  /// other steps, or after more than a quarter of many, or there are none.
  [[nodiscard]] bool cause(std::size_t from, std::size_t count) const {
    const std::size_t earliest = std::max(from, kInputBefore) - kInputBefore;
    const auto first_at = [&](std::size_t row) {
      return static_cast<std::size_t>(std::lower_bound(rows_.begin(), rows_.end(), row) - rows_.begin());
    };
    const std::size_t first = first_at(earliest);
    const std::size_t behind = first_at(from + count + 1);
    if (first == behind) return false;
    const std::size_t apart = first_at(std::max(earliest, kMoved) - kMoved + 1);  // whose motion ends before these rows
    if (apart == 0 && behind == rows_.size()) return true;
    const double elsewhere =
        std::max(apart > 0 ? greatest_to_[apart - 1] : 0.0, behind < rows_.size() ? greatest_from_[behind] : 0.0);
    const auto at = [&](std::size_t i) { return motions_.begin() + static_cast<std::ptrdiff_t>(i); };
    return *std::min_element(at(first), at(behind)) <= kOverAnswers * std::min(elsewhere, usual_);
  }

 private:
  static constexpr std::size_t kMoved = kInputBefore + kMostTogether;  // rows that a step moves soon

  static constexpr std::size_t kFewestSteps = 12;
  static constexpr double kMostSteps = 0.75;  // of them, which a disturbed sensor leaves alone

  std::vector<std::size_t> rows_ = {};
  std::vector<double> motions_ = {};  ///< greatest change of a row soon after each step, a volt of the step
  std::vector<double> greatest_to_ = {};
  std::vector<double> greatest_from_ = {};
  double usual_ = std::numeric_limits<double>::infinity();  ///< no more than that after most of many steps
};

}  // namespace

std::vector<std::size_t> lone_rows(std::span<const double> input, std::span<const double> output) {
  if (output.size() < kFewestWithLone || input.size() != output.size()) return {};
  Scale scale = scale_of(output);
  scale.usual = std::max(scale.usual, scale_of(without_frozen(output)).usual);
  scale.step = ident::value_step(output);
  const Scale of_input = scale_of(input);
  const Steps steps(input, output);
  std::vector<std::size_t> found;
  for (std::size_t k = 1; k + 1 < output.size(); ++k) {
    const std::size_t beyond = rows_beyond(output, k, scale);
    const std::size_t most = std::max(kMostTogether, beyond);
    for (std::size_t count = beyond > kMostTogether ? beyond : 1; count <= most && k + count < output.size(); ++count) {
      if (beyond != count && !stands_alone(output, k, count, scale)) continue;
      if ((beyond != count && continues_a_motion(output, k, count)) || steps.cause(k, count)) continue;
      // A pulse of the input may be answered by one of the output.
      for (std::size_t j = std::max<std::size_t>(k, kInputBefore + 1) - kInputBefore; j <= k; ++j) {
        for (std::size_t width = 1; width <= kMostTogether && j + width < input.size(); ++width) {
          if (stands_alone(input, j, width, of_input)) return {};
        }
      }
      for (std::size_t j = 0; j < count; ++j) found.push_back(k + j);
      k += count;
      break;
    }
  }
  if (static_cast<double>(found.size()) > kMostShare * static_cast<double>(output.size())) return {};
  return found;
}

std::vector<std::size_t> lone_inputs(std::span<const double> input) {
  if (input.size() < kFewestWithLone) return {};
  const Scale scale = scale_of(input);
  if (!(scale.range > 0.0)) return {};
  std::vector<std::size_t> found;
  for (std::size_t k = 1; k + 1 < input.size(); ++k) {
    for (std::size_t count = 1; count <= kMostTogether && k + count < input.size(); ++count) {
      const double middle = 0.5 * (input[k - 1] + input[k + count]);
      const bool is_far = std::all_of(input.begin() + static_cast<std::ptrdiff_t>(k),
                                      input.begin() + static_cast<std::ptrdiff_t>(k + count),
                                      [&](double u) { return std::abs(u - middle) > kInputOverRange * scale.range; });
      if (!is_far || !stands_alone(input, k, count, scale)) continue;
      for (std::size_t j = 0; j < count; ++j) found.push_back(k + j);
      k += count;
      break;
    }
  }
  if (static_cast<double>(found.size()) > kMostShare * static_cast<double>(input.size())) return {};
  return found;
}

std::string lone_rows_text(const std::vector<std::size_t>& rows, std::span<const double> output, double first_s,
                           std::string_view name) {
  const std::size_t first = rows.front();
  std::size_t after = first + 1;
  while (std::binary_search(rows.begin(), rows.end(), after)) ++after;
  return fmt::format("{} row{} of the {} stand{} alone, the first at {} s: {:.5g} between {:.5g} and {:.5g}",
                     rows.size(), rows.size() == 1 ? "" : "s", name, rows.size() == 1 ? "s" : "", time_text(first_s),
                     output[first], output[first - 1], output[after]);
}

}  // namespace eha::importer
