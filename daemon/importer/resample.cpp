// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/resample.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "daemon/importer/time_grid.hpp"

namespace eha::importer {
namespace {

/// Over a whole record the grid may drift from the typical step by this share of a step for the sake of a round number.
constexpr double kDriftForRoundStep = 0.25;
/// Of one kind; more are summed up.
constexpr std::size_t kMostRepairs = 5;

class Resampler {
 public:
  Resampler(const Rows& rows, std::size_t held, const std::filesystem::path& path)
      : rows_(rows), time_s_(rows.columns.front()), held_(held), path_(path) {
    for (std::size_t k = 0; k < time_s_.size(); ++k) {
      const bool complete =
          std::all_of(rows.columns.begin(), rows.columns.end(), [&](const auto& c) { return std::isfinite(c[k]); });
      if (!complete) continue;
      if (!measured_.empty() && !(time_s_[k] > time_s_[measured_.back()])) {
        if (time_s_[k] < time_s_[measured_.back()]) {
          throw DataError(
              fmt::format("{}{}: time goes back from {:.9g} to {:.9g} s; sort the rows, or cut the file there",
                          path_.string(), rows_.where(k), time_s_[measured_.back()], time_s_[k]));
        }
        repeated_.sentences.push_back(fmt::format("{}{}: {:.9g} s again, the row is left out",
                                                  path_.filename().string(), rows_.where(k), time_s_[k]));
        ++repeated_.rows;
        continue;
      }
      measured_.push_back(k);
    }
    if (measured_.size() < 2) {
      throw DataError(fmt::format("{}: {} complete row{}; at least two are needed", path_.string(), measured_.size(),
                                  measured_.size() == 1 ? "" : "s"));
    }
  }

  Resampled run(std::optional<double> period_s) {
    const double typical_s = typical_step();
    constexpr double kFactor = 1.5;
    if (period_s && (*period_s > kFactor * typical_s || *period_s * kFactor < typical_s)) {
      throw DataError(
          fmt::format("{}: --period is {:.9g} s but the rows are about {:.9g} s apart; leave it out, and "
                      "let the fit decimate (--decimate N)",
                      path_.string(), *period_s, typical_s));
    }
    result_.step_s = period_s.value_or(round_step(typical_s));
    result_.start_s = time(0);
    const double steps = std::round((time(measured_.size() - 1) - result_.start_s) / result_.step_s);
    if (steps > 2.0 * static_cast<double>(measured_.size()) + 1000.0) {
      refuse_longest_gap(typical_s);
    }
    const auto count = static_cast<std::size_t>(steps) + 1;
    result_.columns.assign(rows_.columns.size() - 1, std::vector<double>(count));
    for (std::size_t k = 0; k < count; ++k) place(k);
    end_stretch(count);
    report(repeated_, "their time a second time, left out");
    report(filled_, "nothing measured, filled");
    report(moved_, fmt::format("up to {:.3g} s off the grid, moved", moved_.most_s));
    return std::move(result_);
  }

 private:
  [[nodiscard]] double time(std::size_t i) const { return time_s_[measured_[i]]; }

  /// Mean of the steps that are no gap.
  [[nodiscard]] double typical_step() {
    std::vector<double> steps;
    steps.reserve(measured_.size() - 1);
    for (std::size_t i = 1; i < measured_.size(); ++i) steps.push_back(time(i) - time(i - 1));
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>((steps.size() - 1) / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    const double median = *middle;
    double sum = 0.0;
    std::size_t count = 0;
    for (const double step : steps) {
      if (step > 1.5 * median) continue;
      sum += step;
      ++count;
    }
    return count == 0 ? median : sum / static_cast<double>(count);
  }

  [[nodiscard]] double round_step(double typical_s) const {
    const auto rows = static_cast<double>(measured_.size());
    for (int digits = 1; digits < kMostStepDigits; ++digits) {
      const double round = std::stod(fmt::format("{:.{}e}", typical_s, digits - 1));
      if (std::abs(round - typical_s) * rows <= kDriftForRoundStep * typical_s) return round;
    }
    return std::stod(fmt::format("{:.{}e}", typical_s, kMostStepDigits - 1));
  }

  [[noreturn]] void refuse_longest_gap(double typical_s) const {
    std::size_t longest = 1;
    for (std::size_t i = 2; i < measured_.size(); ++i) {
      if (time(i) - time(i - 1) > time(longest) - time(longest - 1)) longest = i;
    }
    throw DataError(fmt::format(
        "{}{}: a gap of {:.9g} s between rows {:.9g} s apart is longer than the record; take a part of it: --to {:.9g}",
        path_.string(), rows_.where(measured_[longest]), time(longest) - time(longest - 1), typical_s,
        time(longest - 1)));
  }

  /// Fills row k of the grid.
  void place(std::size_t k) {
    const double at = result_.start_s + static_cast<double>(k) * result_.step_s;
    while (next_ < measured_.size() && time(next_) <= at) ++next_;
    // The measured rows around the grid point; at the ends there is only one.
    const std::size_t before = next_ == 0 ? 0 : next_ - 1;
    const std::size_t after = std::min(next_, measured_.size() - 1);
    const std::size_t nearest = at - time(before) <= time(after) - at || after == before ? before : after;
    const double off_s = time(nearest) - at;
    const bool is_filled = std::abs(off_s) > 0.5 * result_.step_s * (1.0 + kOnGrid);
    const bool is_moved = !is_filled && std::abs(off_s) > kOnGrid * result_.step_s + quantum_s();
    note(k, is_filled ? Kind::filled : is_moved ? Kind::moved : Kind::measured, nearest, std::abs(off_s));
    const double span = time(after) - time(before);
    const double weight = span > 0.0 ? std::clamp((at - time(before)) / span, 0.0, 1.0) : 0.0;
    for (std::size_t c = 0; c < result_.columns.size(); ++c) {
      const std::vector<double>& source = rows_.columns[c + 1];
      if (c < held_) {
        result_.columns[c][k] = source[measured_[is_filled ? before : nearest]];
      } else if (!is_filled && !is_moved) {
        result_.columns[c][k] = source[measured_[nearest]];
      } else {
        result_.columns[c][k] = (1.0 - weight) * source[measured_[before]] + weight * source[measured_[after]];
      }
    }
    if (is_filled) result_.filled.push_back(k);
  }

  /// Rounding of a printed time [s].
  [[nodiscard]] double quantum_s() const { return rows_.has_lines ? std::pow(10.0, -rows_.time_decimals) : 0.0; }

  enum class Kind { measured, moved, filled };

  void note(std::size_t k, Kind kind, std::size_t nearest, double off_s) {
    if (kind != kind_) {
      end_stretch(k);
      kind_ = kind;
      stretch_from_ = k;
      stretch_row_ = nearest;
      most_off_s_ = 0.0;
    }
    most_off_s_ = std::max(most_off_s_, off_s);
  }

  void end_stretch(std::size_t k) {
    if (kind_ == Kind::measured || stretch_from_ == k) return;
    const std::size_t rows = k - stretch_from_;
    const double from_s = result_.start_s + static_cast<double>(stretch_from_) * result_.step_s;
    const double to_s = result_.start_s + static_cast<double>(k - 1) * result_.step_s;
    const std::string place = path_.filename().string() + rows_.where(measured_[stretch_row_]);
    const std::string span =
        rows == 1 ? fmt::format("at {:.9g} s", from_s) : fmt::format("{:.9g} to {:.9g} s", from_s, to_s);
    const char* plural = rows == 1 ? "" : "s";
    Repairs& repairs = kind_ == Kind::filled ? filled_ : moved_;
    repairs.rows += rows;
    repairs.most_s = std::max(repairs.most_s, most_off_s_);
    repairs.sentences.push_back(
        kind_ == Kind::filled ? fmt::format("{}: {}: nothing measured, {} row{} filled", place, span, rows, plural)
                              : fmt::format("{}: {}: {} row{} up to {:.3g} s off the grid, moved", place, span, rows,
                                            plural, most_off_s_));
  }

  /// All of one kind.
  struct Repairs {
    std::vector<std::string> sentences;
    std::size_t rows = 0;
    double most_s = 0.0;
  };

  void report(const Repairs& repairs, const std::string& what) {
    if (repairs.sentences.size() <= kMostRepairs) {
      result_.repairs.insert(result_.repairs.end(), repairs.sentences.begin(), repairs.sentences.end());
      return;
    }
    result_.repairs.push_back(fmt::format("{}: {} rows in {} places: {}; the first: {}", path_.filename().string(),
                                          repairs.rows, repairs.sentences.size(), what, repairs.sentences.front()));
  }

  const Rows& rows_;
  const std::vector<double>& time_s_;
  std::size_t held_;
  std::filesystem::path path_;
  std::vector<std::size_t> measured_;  ///< rows of the file
  std::size_t next_ = 0;               ///< of measured_, the first after the grid point
  Resampled result_;
  Repairs repeated_;
  Repairs filled_;
  Repairs moved_;
  Kind kind_ = Kind::measured;
  std::size_t stretch_from_ = 0;
  std::size_t stretch_row_ = 0;
  double most_off_s_ = 0.0;
};

}  // namespace

Resampled resample(const Rows& rows, std::size_t held, std::optional<double> period_s,
                   const std::filesystem::path& path) {
  return Resampler(rows, held, path).run(period_s);
}

}  // namespace eha::importer
