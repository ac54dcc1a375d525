// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/output_findings.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "core/time_text.hpp"
#include "daemon/importer/signal_scale.hpp"
#include "ident/record.hpp"
#include "ident/signal/kept_values.hpp"
#include "ident/signal/most_moving_part.hpp"
#include "ident/signal/rest_at_ends.hpp"
#include "ident/signal/value_step.hpp"

namespace eha::importer {
namespace {

constexpr std::size_t kFewestRows = 60;
constexpr double kClippedShare = 0.02;  // of the rows
constexpr std::size_t kClippedTogether = 5;
constexpr double kPile = 3.0;                // rows at the end of a coarse sensor over those at its next value
constexpr double kBesideEnd = 0.002;         // of the output's range, as a rod on its end stop
constexpr std::size_t kTimesOfACommand = 3;  // an output that is held so often is rather a command
constexpr double kShareHeld = 0.8;           // of the rows
constexpr std::size_t kFrozenRows = 20;
constexpr double kFrozenShare = 0.01;  // of the rows
constexpr double kFrozenInput = 0.3;   // of the input's range
constexpr std::size_t kFewestChanges = 30;
constexpr std::size_t kFewestMotions = 20;
constexpr double kIntegrates = 0.6;        // R2 of the motion by the input
constexpr double kByPlace = 0.7;           // of what that leaves over, where the place tells of the motion, too
constexpr double kBandOverUsual = 10.0;    // band of a rod on its end stop, over the usual distance of a row
constexpr double kWidestEndBand = 0.02;    // ... over the output's range
constexpr double kAskedOverBand = 3.0;     // motion beyond the stop that the input asks for
constexpr double kAskedOverStep = 6.0;     // ... over the step of a coarse sensor, as a rod turns round within a few
constexpr std::size_t kCoarsePlaces = 60;  // of a record, over each of which a coarse sensor shows the motion
constexpr double kHeldShare = 0.9;         // of the changes of a sensor that is read more slowly than the rows
constexpr double kRougher = 1.5;           // roughness of a rod over that of its command
constexpr std::size_t kRoughPlaces = 500;  // of a record, over which roughness is taken
constexpr std::size_t kLaggedRows = 2000;  // means of a record that a lag is fitted to
constexpr double kExplained = 0.7;         // share of the other column's variance, by a lag of what is taken for output
constexpr double kExplainedMore = 0.3;     // than the other way round; right records differ by 0.7 to 0.9

/// First and last row.
using Stretch = std::pair<std::size_t, std::size_t>;

/// Each stretch of rows that lie next to one another.
std::vector<Stretch> stretches(const std::vector<std::size_t>& rows, std::size_t shortest) {
  std::vector<Stretch> found;
  for (const std::size_t row : rows) {
    if (!found.empty() && found.back().second + 1 == row) {
      found.back().second = row;
    } else {
      found.emplace_back(row, row);
    }
  }
  std::erase_if(found, [&](const auto& stretch) { return stretch.second - stretch.first + 1 < shortest; });
  return found;
}

/// First row and the row behind the last of the longest part of `count` rows without a stretch.
Stretch longest_part(const std::vector<Stretch>& stretches, std::size_t count) {
  std::size_t begin = 0;
  Stretch longest{0, 0};
  for (const auto& [first, last] : stretches) {
    if (first > begin && first - begin > longest.second - longest.first) longest = {begin, first};
    begin = std::max(begin, last + 1);
  }
  if (count - begin > longest.second - longest.first) longest = {begin, count};
  return longest;
}

/// The options that keep the rows of a part, given by its first row and the row behind its last.
Cut cut_to(const Stretch& part, std::size_t count, double start_s, double step_s) {
  const auto time = [&](std::size_t row) { return start_s + static_cast<double>(row) * step_s; };
  Cut cut;
  if (part.second <= part.first) return cut;
  if (part.first > 0) cut.from_s = time(part.first);
  if (part.second < count) cut.to_s = time(part.second - 1);
  return cut;
}

/// "32 % of the rows have the output 85, its greatest value, and 12 % 55, its least: ..."; empty without such rows.
/// @param clipped  stretches of these rows, with those beside them at the same place
std::string clipped_text(const std::vector<double>& input, const std::vector<double>& output,
                         std::vector<Stretch>& clipped) {
  const auto extremes = std::minmax_element(output.begin(), output.end());
  const auto least = extremes.first;
  const auto greatest = extremes.second;
  if (!(*least < *greatest)) return {};
  const auto as_vector = [](const std::vector<double>& x) {
    return Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
  };
  if (ident::rests_at_both_ends(as_vector(input), as_vector(output))) return {};
  std::string text;
  const double step = ident::value_step(output);
  const auto rows_at = [&](double extreme) {
    std::vector<std::size_t> at;
    for (std::size_t k = 0; k < output.size(); ++k) {
      // Equal to the bit: a converter at its end.
      if (ident::is_same_value(output[k], extreme)) at.push_back(k);
    }
    // A coarse sensor has many rows at each of its values.
    const double next = extreme < *greatest ? extreme + step : extreme - step;
    const auto beside = std::count_if(output.begin(), output.end(),
                                      [&](double y) { return step > 0.0 && std::abs(y - next) < 0.5 * step; });
    const bool is_pile = static_cast<double>(at.size()) >= kPile * static_cast<double>(beside);
    return !is_pile || stretches(at, kClippedTogether).empty() ? std::vector<std::size_t>() : at;
  };
  const std::array<std::vector<std::size_t>, 2> ends{rows_at(*greatest), rows_at(*least)};
  const std::size_t most = std::max(ends[0].size(), ends[1].size());
  // Where the sensor reaches one of its ends, a few rows are enough at the other.
  if (static_cast<double>(most) < kClippedShare * static_cast<double>(output.size())) return {};
  for (const std::vector<std::size_t>& at : ends) {
    if (at.empty()) continue;
    const double extreme = output[at.front()];
    std::vector<std::size_t> beside;
    for (std::size_t k = 0; k < output.size(); ++k) {
      if (std::abs(output[k] - extreme) <= kBesideEnd * (*greatest - *least)) beside.push_back(k);
    }
    const std::vector<Stretch> found = stretches(beside, kClippedTogether);
    clipped.insert(clipped.end(), found.begin(), found.end());
    text += fmt::format("{}{:.2g} % {}{:.6g}, its {} value", text.empty() ? "" : ", and ",
                        100.0 * static_cast<double>(at.size()) / static_cast<double>(output.size()),
                        text.empty() ? "of the rows have the output " : "", extreme,
                        extreme < *greatest ? "least" : "greatest");
  }
  return text.empty() ? text : text + ": the sensor is at its end, a rod stands, or the output has settled";
}

/// "from 42 to 42.29 s", of several the longest; empty without one.
std::string longest_of(const std::vector<Stretch>& found, double start_s, double step_s) {
  if (found.empty()) return {};
  const auto [first, last] = *std::max_element(found.begin(), found.end(), [](const Stretch& a, const Stretch& b) {
    return a.second - a.first < b.second - b.first;
  });
  const auto time = [&](std::size_t row) { return time_text(start_s + static_cast<double>(row) * step_s); };
  const std::string span = fmt::format("from {} to {} s", time(first), time(last));
  return found.size() == 1 ? span : fmt::format("in {} places, the longest {}", found.size(), span);
}

/// Stretches over which the output keeps a value to the bit, between its extremes, while the input moves over a large
/// part of its range in their first half: no rod does that. Behind a switch in the second half it may not have moved
/// by a step of its sensor yet.
std::vector<Stretch> frozen_stretches(const std::vector<double>& input, const std::vector<double>& output) {
  const auto [least, greatest] = std::minmax_element(output.begin(), output.end());
  const auto [lowest, highest] = std::minmax_element(input.begin(), input.end());
  const auto shortest =
      std::max(kFrozenRows, static_cast<std::size_t>(kFrozenShare * static_cast<double>(output.size())));
  std::vector<Stretch> found;
  for (std::size_t k = 0; k < output.size();) {
    std::size_t end = k + 1;
    while (end < output.size() && ident::is_same_value(output[end], output[k])) ++end;
    if (end - k >= shortest && output[k] > *least && output[k] < *greatest) {
      const auto [from, to] = std::minmax_element(input.begin() + static_cast<std::ptrdiff_t>(k),
                                                  input.begin() + static_cast<std::ptrdiff_t>(k + (end - k) / 2));
      if (*to - *from > kFrozenInput * (*highest - *lowest)) found.emplace_back(k, end - 1);
    }
    k = end;
  }
  return found;
}

/// Whether most rows have the value of the row before to the bit.
bool is_held_as_a_command(const std::vector<double>& signal) {
  std::size_t same = 0;
  for (std::size_t k = 1; k < signal.size(); ++k) {
    if (ident::is_same_value(signal[k], signal[k - 1])) ++same;
  }
  return static_cast<double>(same) > kShareHeld * static_cast<double>(signal.size());
}

/// Motion of the output over a window by the mean input in it, as a straight line.
struct Motion {
  double at_0 = 0.0;
  double slope = 0.0;
  bool is_known = false;
  bool is_by_place = false;  ///< where the rod is tells of the motion, too: it comes to rest by itself
  std::vector<std::pair<double, double>> seen = {};  ///< the windows: input and motion, by rising input

  /// The median motion of the windows with about this input, over which a valve's dead band makes none; none with fewer
  /// than three.
  [[nodiscard]] std::optional<double> usual(double input) const {
    constexpr double kAlike = 0.05;  // of the input's range
    constexpr std::ptrdiff_t kFewestAlike = 3;
    const double reach = seen.empty() ? 0.0 : kAlike * (seen.back().first - seen.front().first);
    const auto before = [](const auto& one, double u) { return one.first < u; };
    const auto first = std::lower_bound(seen.begin(), seen.end(), input - reach, before);
    const auto behind = std::lower_bound(first, seen.end(), input + reach, before);
    if (behind - first < kFewestAlike) return std::nullopt;
    std::vector<double> motions;
    std::transform(first, behind, std::back_inserter(motions), [](const auto& one) { return one.second; });
    return quantile(std::move(motions), 0.5);
  }
};

/// The line through the windows of a record that no stretch touches; not known where the output does not integrate.
Motion motion_by_input(const std::vector<double>& input, const std::vector<double>& output, std::size_t window,
                       const std::vector<Stretch>& without) {
  std::vector<double> u;
  std::vector<double> y;
  std::vector<double> places;
  for (std::size_t k = 0; k + window < output.size(); k += window) {
    const auto touches = [&](const Stretch& stretch) { return k + window >= stretch.first && k <= stretch.second; };
    if (std::any_of(without.begin(), without.end(), touches)) continue;
    const auto first = input.begin() + static_cast<std::ptrdiff_t>(k);
    u.push_back(std::accumulate(first, first + static_cast<std::ptrdiff_t>(window), 0.0) / static_cast<double>(window));
    y.push_back(output[k + window] - output[k]);
    places.push_back(output[k]);
  }
  if (u.size() < kFewestMotions) return {};
  const Eigen::Map<const Eigen::ArrayXd> inputs(u.data(), static_cast<Eigen::Index>(u.size()));
  const Eigen::Map<const Eigen::ArrayXd> motions(y.data(), static_cast<Eigen::Index>(y.size()));
  const Eigen::ArrayXd du = inputs - inputs.mean();
  const Eigen::ArrayXd dy = motions - motions.mean();
  const double uu = du.square().sum();
  const double yy = dy.square().sum();
  const double uy = (du * dy).sum();
  if (!(uy * uy > kIntegrates * uu * yy)) return {};
  Eigen::MatrixXd regressors(inputs.size(), 2);
  const Eigen::Map<const Eigen::ArrayXd> place(places.data(), inputs.size());
  regressors << du.matrix(), (place - place.mean()).matrix();
  const Eigen::VectorXd solution = regressors.colPivHouseholderQr().solve(dy.matrix());
  const double by_both = (dy.matrix() - regressors * solution).squaredNorm();
  Motion motion{motions.mean() - uy / uu * inputs.mean(), uy / uu, true, by_both < kByPlace * (yy - uy * uy / uu)};
  for (std::size_t i = 0; i < u.size(); ++i) motion.seen.emplace_back(u[i], y[i]);
  std::sort(motion.seen.begin(), motion.seen.end());
  return motion;
}

/// Those of the stretches in which a rod that integrates would have moved by several steps of a coarse sensor.
std::vector<Stretch> beyond_a_step(std::vector<Stretch> found, const std::vector<double>& input,
                                   const std::vector<double>& output) {
  const double step = found.empty() ? 0.0 : ident::value_step(output);
  const std::size_t window = std::max(kClippedTogether, output.size() / kCoarsePlaces);
  const Motion motion = step > 0.0 ? motion_by_input(input, output, window, found) : Motion{};
  if (!motion.is_known) return found;
  std::erase_if(found, [&](const Stretch& stretch) {
    double asked = 0.0;
    double most = 0.0;
    for (std::size_t k = stretch.first; k <= stretch.second; ++k) {
      asked += (motion.at_0 + motion.slope * input[k]) / static_cast<double>(window);
      most = std::max(most, std::abs(asked));
    }
    return most < kAskedOverStep * step;
  });
  return found;
}

constexpr double kAskedBack = 0.1;  // of the range

/// Stretches over which the output stands at its greatest or least value while the input asks it to go on, and shorter
/// ones at the same end.
std::vector<Stretch> end_stops(const std::vector<double>& input, const std::vector<double>& output) {
  const double least = *std::min_element(output.begin(), output.end());
  const double greatest = *std::max_element(output.begin(), output.end());
  const double range = greatest - least;
  const std::size_t window = std::max(kClippedTogether, output.size() / kRoughPlaces);
  // Of the least value the noise makes the outermost of many.
  const double band = std::clamp(kBandOverUsual * scale_of(output).usual, kBesideEnd * range, kWidestEndBand * range);
  const double step = ident::value_step(output);
  const auto shortest =
      std::max(kFrozenRows, static_cast<std::size_t>(kClippedShare * static_cast<double>(output.size())));
  const auto at_end = [&](double side) {
    const double extreme = side > 0.0 ? greatest : least;
    std::vector<std::size_t> at;
    for (std::size_t k = 0; k < output.size(); ++k) {
      if (side * (extreme - output[k]) <= band) at.push_back(k);
    }
    return stretches(at, kClippedTogether);
  };
  const std::array<std::vector<Stretch>, 2> ends{at_end(1.0), at_end(-1.0)};
  const auto is_long = [&](const Stretch& stretch) { return stretch.second - stretch.first + 1 >= shortest; };
  std::vector<Stretch> all;
  for (const auto& end : ends) std::copy_if(end.begin(), end.end(), std::back_inserter(all), is_long);
  const Motion motion = all.empty() ? Motion{} : motion_by_input(input, output, window, all);
  // A plant that levels itself rests at an end as long as its input does, without any stop.
  if (!motion.is_known || motion.is_by_place) return {};
  std::vector<Stretch> found;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const double side = i == 0 ? 1.0 : -1.0;
    const bool is_stop = std::any_of(ends[i].begin(), ends[i].end(), [&](const Stretch& stretch) {
      if (!is_long(stretch)) return false;
      double asked = 0.0;
      double most = 0.0;
      double usual = 0.0;
      double asked_back = 0.0;
      double most_back = 0.0;
      for (std::size_t k = stretch.first; k <= stretch.second; ++k) {
        const double line = side * (motion.at_0 + motion.slope * input[k]) / static_cast<double>(window);
        if ((k - stretch.first) % window == 0) {
          usual = side * motion.usual(input[k]).value_or(0.0) / static_cast<double>(window);
        }
        asked = std::max(0.0, asked + std::min(line, usual));
        most = std::max(most, asked);
        asked_back = std::max(0.0, asked_back - line);
        most_back = std::max(most_back, asked_back);
      }
      // A rod on its stop comes back where it is asked to; one that does not answers to nothing.
      const double little = kAskedOverBand * std::max(band, step);
      return most > little && most_back < std::max(little, kAskedBack * range);
    });
    if (is_stop) found.insert(found.end(), ends[i].begin(), ends[i].end());
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// Rows for which a sensor keeps each of its values; none for one that is read with every row, or whose steps are those
/// of its converter: a rod that slows down keeps such a value for ever longer.
std::optional<std::size_t> held_rows(const std::vector<double>& output) {
  std::vector<double> lengths;
  std::size_t since = 0;
  for (std::size_t k = 1; k < output.size(); ++k) {
    if (ident::is_same_value(output[k], output[k - 1])) continue;
    if (since > 0) lengths.push_back(static_cast<double>(k - since));
    since = k;
  }
  if (lengths.size() < kFewestChanges) return std::nullopt;
  const double usual = quantile(lengths, 0.5);
  if (usual < 2.0) return std::nullopt;
  // A clock of its own makes one row more or less.
  const double about = usual < 3.0 ? 0.0 : 1.0;
  const auto held =
      std::count_if(lengths.begin(), lengths.end(), [&](double length) { return std::abs(length - usual) <= about; });
  if (static_cast<double>(held) < kHeldShare * static_cast<double>(lengths.size())) return std::nullopt;
  return static_cast<std::size_t>(usual);
}

/// Mean change over a short part of the record, over the range of the middle 98 %: of a signal that a plant has
/// smoothed it is less than of what moved the plant.
double roughness(const std::vector<double>& values) {
  const std::size_t lag = std::max<std::size_t>(1, values.size() / kRoughPlaces);
  double sum = 0.0;
  for (std::size_t k = lag; k < values.size(); k += lag) sum += std::abs(values[k] - values[k - lag]);
  const double range = quantile(values, 0.99) - quantile(values, 0.01);
  return range > 0.0 ? sum / range : 0.0;
}

std::vector<double> block_means(const std::vector<double>& values, std::size_t most) {
  const std::size_t width = std::max<std::size_t>(1, (values.size() + most - 1) / most);
  std::vector<double> means;
  for (std::size_t k = 0; k + width <= values.size(); k += width) {
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(k);
    means.push_back(std::accumulate(first, first + static_cast<std::ptrdiff_t>(width), 0.0) /
                    static_cast<double>(width));
  }
  return means;
}

/// Greatest share of the variance of an effect that a lag of its cause explains, with an offset and a drift or the
/// lag's own decay: from no lag to an integrator. What precedes its cause is explained by none.
double explained_share(const std::vector<double>& cause, const std::vector<double>& effect) {
  constexpr double kShortest_rows = 0.25;
  constexpr double kLongest_records = 20.0;
  constexpr double kNextLag = 1.6;
  const auto rows = static_cast<Eigen::Index>(effect.size());
  const Eigen::Map<const Eigen::VectorXd> y(effect.data(), rows);
  const double variance = (y.array() - y.mean()).square().sum();
  if (!(variance > 0.0)) return 0.0;
  const double mean = std::accumulate(cause.begin(), cause.end(), 0.0) / static_cast<double>(rows);
  double share = 0.0;
  Eigen::MatrixXd regressors(rows, 3);
  for (double lag = kShortest_rows; lag < kLongest_records * static_cast<double>(rows); lag *= kNextLag) {
    const double kept = std::exp(-1.0 / lag);
    const bool integrates = lag > 2.0 * static_cast<double>(rows);
    double lagged = 0.0;
    double decay = 1.0;
    for (Eigen::Index k = 0; k < rows; ++k) {
      regressors.row(k) << lagged, 1.0, integrates ? static_cast<double>(k) / static_cast<double>(rows) : decay;
      lagged = kept * lagged + (1.0 - kept) * (cause[static_cast<std::size_t>(k)] - mean);
      decay *= kept;
    }
    const double size = regressors.col(0).norm();
    if (!(size > 0.0)) continue;
    regressors.col(0) /= size;
    const Eigen::VectorXd solution = regressors.colPivHouseholderQr().solve(y);
    share = std::max(share, 1.0 - (y - regressors * solution).squaredNorm() / variance);
  }
  return share;
}

/// Whether one value and one slope of the cause give the effect, as with a single tone: a lag of more than half a turn
/// is then a lead.
bool is_one_tone(const std::vector<double>& cause, const std::vector<double>& effect) {
  constexpr double kAll = 0.9;
  const auto rows = static_cast<Eigen::Index>(effect.size()) - 2;
  const Eigen::VectorXd y = Eigen::Map<const Eigen::VectorXd>(effect.data() + 1, rows);
  const Eigen::Map<const Eigen::VectorXd> u(cause.data(), rows + 2);
  Eigen::MatrixXd regressors(rows, 4);
  regressors << u.segment(1, rows), u.tail(rows) - u.head(rows), Eigen::VectorXd::Ones(rows),
      Eigen::VectorXd::LinSpaced(rows, 0.0, 1.0);
  const Eigen::VectorXd solution = regressors.colPivHouseholderQr().solve(y);
  return (y - regressors * solution).squaredNorm() < (1.0 - kAll) * (y.array() - y.mean()).square().sum();
}

bool is_comparable(const std::vector<double>& input, const std::vector<double>& output) {
  const auto is_finite = [](double x) { return std::isfinite(x); };
  return output.size() >= kFewestRows && std::all_of(input.begin(), input.end(), is_finite) &&
         std::all_of(output.begin(), output.end(), is_finite);
}

}  // namespace

std::string why_exchanged(const std::vector<double>& input, const std::vector<double>& output) {
  if (!is_comparable(input, output)) return {};
  const double of_input = roughness(input);
  if (of_input > 0.0 && roughness(output) > kRougher * of_input) {
    return "a rod moves more smoothly than its command, and here the input is the smoother one";
  }
  return why_later_than_its_output(input, output);
}

std::string why_later_than_its_output(const std::vector<double>& input, const std::vector<double>& output) {
  if (!is_comparable(input, output)) return {};
  const std::vector<double> u = block_means(input, kLaggedRows);
  const std::vector<double> y = block_means(output, kLaggedRows);
  if (is_one_tone(u, y) || is_one_tone(y, u)) return {};
  const double given = explained_share(u, y);
  const double exchanged = explained_share(y, u);
  if (exchanged < kExplained || exchanged < given + kExplainedMore) return {};
  return fmt::format(
      "a lag of the output explains {:.0f} % of the input, a lag of the input {:.0f} % of the output, so that the "
      "output comes before the input",
      100.0 * exchanged, 100.0 * std::max(0.0, given));
}

std::pair<std::size_t, std::size_t> longest_part_without(const std::vector<std::size_t>& rows, std::size_t count) {
  const auto [first, behind] = longest_part(stretches(rows, 1), count);
  return {first, behind - 1};
}

OutputFindings findings_on_output(const std::vector<double>& input, const std::vector<double>& output,
                                  const std::vector<std::size_t>& filled, double start_s, double step_s,
                                  bool may_be_exchanged) {
  OutputFindings findings;
  std::vector<std::string>& remarks = findings.remarks;
  if (output.size() < kFewestRows) return findings;
  if (const auto held = may_be_exchanged ? std::nullopt : held_rows(output)) {
    const double held_s = static_cast<double>(*held) * step_s;
    remarks.push_back(fmt::format(
        "the output changes only every {} rows, {:.3g} s: the sensor is read more slowly than the record has "
        "rows; its readings are up to {:.3g} s old, half of that on average, which a model takes for dead "
        "time or lag; record the sensor with every row",
        *held, held_s, held_s - step_s));
  }
  std::vector<Stretch> spoilt;
  const auto add = [&](std::string remark, const std::vector<Stretch>& stretches) {
    if (stretches.empty()) return;
    remarks.push_back(std::move(remark));
    spoilt.insert(spoilt.end(), stretches.begin(), stretches.end());
  };
  std::vector<Stretch> clipped;
  const std::string at_ends = clipped_text(input, output, clipped);
  add(at_ends, clipped);
  const auto time = [&](std::size_t row) { return start_s + static_cast<double>(row) * step_s; };
  if (const std::vector<Stretch> stops = clipped.empty() ? end_stops(input, output) : std::vector<Stretch>();
      !stops.empty()) {
    std::size_t rows = 0;
    for (const auto& [first, last] : stops) rows += last - first + 1;
    add(fmt::format(
            "the output stands at an end for {:.2g} % of the rows, from {} s on at {:.6g}, while the input pushes "
            "on: a rod is on its end stop, or the sensor at its end",
            100.0 * static_cast<double>(rows) / static_cast<double>(output.size()),
            time_text(time(stops.front().first)), output[stops.front().first]),
        stops);
  }
  const std::vector<Stretch> frozen = beyond_a_step(frozen_stretches(input, output), input, output);
  if (frozen.size() >= kTimesOfACommand && is_held_as_a_command(output) && !is_held_as_a_command(input)) {
    remarks.push_back(fmt::format(
        "the output keeps one value to the last digit in {} places while the input moves, as a command does "
        "that is held: input and output may be exchanged",
        frozen.size()));
  } else if (!frozen.empty()) {
    add(fmt::format("the output stays at {:.6g} to the last digit from {} to {} s{}, while the input moves: the "
                    "sensor, or what reads it, froze",
                    output[frozen.front().first], time_text(time(frozen.front().first)),
                    time_text(time(frozen.front().second)),
                    frozen.size() > 1 ? fmt::format(" and {} more times alike", frozen.size() - 1) : ""),
        frozen);
    findings.frozen = longest_of(frozen, start_s, step_s);
  }
  add(fmt::format(
          "what the input did in a filled gap of {} rows or more is not known, and a rod that integrates stands "
          "elsewhere afterwards",
          ident::kRowsOfGap),
      stretches(filled, ident::kRowsOfGap));
  if (!spoilt.empty()) {
    std::sort(spoilt.begin(), spoilt.end());
    const Stretch longest = longest_part(spoilt, output.size());
    const auto moving = ident::most_moving_part(output, spoilt);
    if (moving) findings.cut = cut_to(*moving, output.size(), start_s, step_s);
    const std::string any = remarks.size() > 1 ? " any of this" : "";
    const std::string options = cut_options(findings.cut);
    if (longest.second <= longest.first) {
      remarks.back() += "; no part is without";
    } else if (options.empty()) {
      remarks.back() += "; the output moves in no part without" + any;
    } else {
      remarks.back() += fmt::format("; the {} without{}{}: {}", moving == longest ? "longest part" : "part", any,
                                    moving == longest ? "" : " that moves most", options);
    }
  }
  return findings;
}

Cut part_without_gaps(const std::vector<std::size_t>& filled, std::size_t count, double start_s, double step_s) {
  return cut_to(longest_part(stretches(filled, ident::kRowsOfGap), count), count, start_s, step_s);
}

std::string gaps_text(const std::vector<std::size_t>& filled, double start_s, double step_s) {
  return longest_of(stretches(filled, ident::kRowsOfGap), start_s, step_s);
}

std::string cut_options(const Cut& cut) {
  std::string text;
  if (cut.from_s) text += "--from " + time_text(*cut.from_s);
  if (cut.to_s) text += (text.empty() ? "--to " : " --to ") + time_text(*cut.to_s);
  return text;
}

}  // namespace eha::importer
