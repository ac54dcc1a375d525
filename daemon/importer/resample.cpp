// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/resample.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/time_text.hpp"
#include "daemon/importer/time_grid.hpp"
#include "ident/record.hpp"

namespace eha::importer {
namespace {

constexpr int kTimeDigits = 9;

/// Over a whole record the grid may drift from the typical step by this share of a step for the sake of a round number.
constexpr double kDriftForRoundStep = 0.25;
/// A point between two measured rows that are at most so many steps apart is no gap.
constexpr double kNeighbours = 1.5;
/// Of the rows, off the grid: from there on it is the clock that is uneven, not a few late rows.
constexpr double kUneven = 0.3;
/// Of one kind; more are summed up.
constexpr std::size_t kMostRepairs = 5;

/// The measured values of one column, and where in them the grid is.
struct Source {
  std::vector<std::size_t> rows = {};  ///< of the file
  std::size_t next = 0;                ///< of rows, the first after the grid point
};

/// How the values of a grid point came about; of several columns the gravest.
enum class Kind { measured, moved, output_filled, input_filled, filled };

/// The steps without those at which a row is missing, or one too many.
struct SoundSteps {
  double mean = 0.0;
  std::size_t count = 0;
};

SoundSteps sound_steps(std::vector<double> steps) {
  constexpr double kOther = 0.75;  // of the median, off it
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>((steps.size() - 1) / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const double median = *middle;
  double sum = 0.0;
  std::size_t count = 0;
  for (const double step : steps) {
    if (std::abs(step - median) > kOther * median) continue;
    sum += step;
    ++count;
  }
  return {count == 0 ? median : sum / static_cast<double>(count), count};
}

class Resampler {
 public:
  Resampler(const Rows& rows, std::size_t held, const std::filesystem::path& path)
      : rows_(rows), time_s_(rows.columns.front()), held_(held), path_(path), sources_(rows.columns.size() - 1) {
    for (std::size_t k = 0; k < time_s_.size(); ++k) {
      if (!std::isfinite(time_s_[k]) || !is_any_measured(k)) continue;
      if (!timed_.empty() && !(time_s_[k] > time_s_[timed_.back()])) {
        if (time_s_[k] < time_s_[timed_.back()]) {
          throw DataError(fmt::format("{}{}: time goes back from {} to {} s; sort the rows, or cut the file there",
                                      path_.string(), rows_.where(k), time_text(time_s_[timed_.back()], kTimeDigits),
                                      time_text(time_s_[k], kTimeDigits)));
        }
        repeat(k);
        continue;
      }
      timed_.push_back(k);
      for (std::size_t c = 0; c < sources_.size(); ++c) {
        if (std::isfinite(values(c)[k])) sources_[c].rows.push_back(k);
      }
    }
    leave_out_ends();
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
    const double steps = std::round((time(timed_.size() - 1) - result_.start_s) / result_.step_s);
    if (steps > 2.0 * static_cast<double>(timed_.size()) + 1000.0) {
      refuse_longest_gap(typical_s);
    }
    const auto count = static_cast<std::size_t>(steps) + 1;
    result_.columns.assign(sources_.size(), std::vector<double>(count));
    for (std::size_t k = 0; k < count; ++k) place(k);
    end_stretch(count);
    if (static_cast<double>(moved_.rows) > kUneven * static_cast<double>(count)) {
      for (std::size_t c = 0; c < held_; ++c) average(c);
      result_.is_averaged = held_ > 0;
    }
    report(repeated_, "their time a second time, left out");
    report(filled_, "nothing measured, filled");
    report(output_filled_, "no output measured, it is interpolated; their input is kept");
    report(input_filled_, "no input measured, it is filled; their output is kept");
    result_.moved_rows = moved_.rows;
    result_.most_moved_s = moved_.most_s;
    report(moved_, fmt::format("up to {:.3g} s off the grid, moved", moved_.most_s));
    return std::move(result_);
  }

 private:
  [[nodiscard]] double time(std::size_t i) const { return time_s_[timed_[i]]; }

  [[nodiscard]] const std::vector<double>& values(std::size_t c) const { return rows_.columns[c + 1]; }
  [[nodiscard]] bool is_any_measured(std::size_t row) const {
    return std::any_of(rows_.columns.begin() + 1, rows_.columns.end(),
                       [&](const std::vector<double>& column) { return std::isfinite(column[row]); });
  }

  /// A second row of one time: what the first lacks is taken from it.
  void repeat(std::size_t k) {
    bool adds = false;
    for (std::size_t c = 0; c < sources_.size(); ++c) {
      std::vector<std::size_t>& rows = sources_[c].rows;
      const bool has_value = !rows.empty() && !(time_s_[rows.back()] < time_s_[k]);
      if (has_value || !std::isfinite(values(c)[k])) continue;
      rows.push_back(k);
      adds = true;
    }
    if (adds) return;
    repeated_.sentences.push_back(fmt::format("{}{}: {} s again, the row is left out", path_.filename().string(),
                                              rows_.where(k), time_text(time_s_[k], kTimeDigits)));
    ++repeated_.rows;
  }

  /// Before the first and behind the last value of a column nothing is known that a value could be filled from.
  void leave_out_ends() {
    for (const Source& source : sources_) {
      if (source.rows.size() < 2) {
        throw DataError(fmt::format("{}: a column has {} value{}; at least two are needed of input and output each",
                                    path_.string(), source.rows.size(), source.rows.size() == 1 ? "" : "s"));
      }
    }
    double from_s = time(0);
    double to_s = time_s_[timed_.back()];
    for (const Source& source : sources_) {
      from_s = std::max(from_s, time_s_[source.rows.front()]);
      to_s = std::min(to_s, time_s_[source.rows.back()]);
    }
    std::erase_if(timed_, [&](std::size_t row) { return time_s_[row] < from_s || time_s_[row] > to_s; });
    if (timed_.size() < 2) {
      throw DataError(fmt::format("{}: {} row{} within the times of input and output; at least two are needed",
                                  path_.string(), timed_.size(), timed_.size() == 1 ? "" : "s"));
    }
  }

  /// Of the steps that are no gap; where there is none, of all rows together.
  [[nodiscard]] double typical_step() {
    std::vector<double> steps;
    steps.reserve(timed_.size() - 1);
    for (std::size_t i = 1; i < timed_.size(); ++i) steps.push_back(time(i) - time(i - 1));
    const SoundSteps sound = sound_steps(steps);
    return sound.count == steps.size() ? slope() : sound.mean;
  }

  /// Of the times by the rows, by least squares: the first and the last time scatter as the others do.
  [[nodiscard]] double slope() const {
    const double middle = 0.5 * static_cast<double>(timed_.size() - 1);
    double rise = 0.0;
    double power = 0.0;
    for (std::size_t i = 0; i < timed_.size(); ++i) {
      const double place = static_cast<double>(i) - middle;
      rise += place * (time(i) - time(0));
      power += place * place;
    }
    return rise / power;
  }

  [[nodiscard]] double round_step(double typical_s) const {
    const auto rows = static_cast<double>(timed_.size());
    for (int digits = 1; digits < kMostStepDigits; ++digits) {
      const double round = std::stod(fmt::format("{:.{}e}", typical_s, digits - 1));
      if (std::abs(round - typical_s) * rows <= kDriftForRoundStep * typical_s) return round;
    }
    return std::stod(fmt::format("{:.{}e}", typical_s, kMostStepDigits - 1));
  }

  [[noreturn]] void refuse_longest_gap(double typical_s) const {
    std::size_t longest = 1;
    for (std::size_t i = 2; i < timed_.size(); ++i) {
      if (time(i) - time(i - 1) > time(longest) - time(longest - 1)) longest = i;
    }
    throw DataError(fmt::format(
        "{}{}: a gap of {:.9g} s between rows {:.9g} s apart is longer than the record; take a part of it: --to {}",
        path_.string(), rows_.where(timed_[longest]), time(longest) - time(longest - 1), typical_s,
        time_text(time(longest - 1), kTimeDigits)));
  }

  /// Fills row k of the grid.
  void place(std::size_t k) {
    const double at = result_.start_s + static_cast<double>(k) * result_.step_s;
    Kind kind = Kind::measured;
    std::size_t nearest = 0;
    double off_s = 0.0;
    for (std::size_t c = 0; c < sources_.size(); ++c) {
      const Placed placed = place(c, at);
      result_.columns[c][k] = placed.value;
      Kind of_column = placed.kind;
      if (c <= held_ && of_column == Kind::filled && held_ < sources_.size()) {
        of_column = c < held_ ? Kind::input_filled : Kind::output_filled;
        const bool are_both = kind == Kind::input_filled && of_column == Kind::output_filled;
        if (are_both) of_column = Kind::filled;
      }
      if (c > 0 && of_column <= kind) continue;
      kind = of_column;
      nearest = placed.row;
      off_s = placed.off_s;
    }
    // What was not measured is not in the nearest measured row.
    note(k, kind, kind == Kind::measured || kind == Kind::moved ? nearest : row_at(at), off_s);
    if (kind == Kind::filled || kind == Kind::input_filled || kind == Kind::output_filled) result_.filled.push_back(k);
    if (kind == Kind::filled || kind == Kind::input_filled) result_.held.push_back(k);
  }

  /// Row of the file at a time of the grid, which may lack values; in a gap the one after it. Times must not fall.
  [[nodiscard]] std::size_t row_at(double at) {
    const double from_s = at - 0.5 * result_.step_s * (1.0 + kOnGrid);
    while (next_row_ + 1 < time_s_.size() && !(time_s_[next_row_] >= from_s)) ++next_row_;
    return next_row_;
  }

  struct Placed {
    double value = 0.0;
    Kind kind = Kind::measured;
    std::size_t row = 0;  ///< of the file, the nearest in time
    double off_s = 0.0;   ///< of that row from the grid point
  };

  /// Value of a column at a time, from its measured rows around it; at the ends there is only one.
  [[nodiscard]] Placed place(std::size_t c, double at) {
    const std::vector<std::size_t>& rows = sources_[c].rows;
    std::size_t& next = sources_[c].next;
    while (next < rows.size() && time_s_[rows[next]] <= at) ++next;
    const std::size_t before = rows[next == 0 ? 0 : next - 1];
    const std::size_t after = rows[std::min(next, rows.size() - 1)];
    const bool is_before = at - time_s_[before] <= time_s_[after] - at || after == before;
    Placed placed{.row = is_before ? before : after};
    placed.off_s = std::abs(time_s_[placed.row] - at);
    const double span_s = time_s_[after] - time_s_[before];
    const bool is_far = span_s > kNeighbours * result_.step_s;
    // A switch somewhere in a short gap is on average a straight line; the row before would move it to the end.
    const bool is_gap = span_s > (static_cast<double>(ident::kRowsOfGap) + 0.5) * result_.step_s;
    const bool is_filled = is_far && placed.off_s > 0.5 * result_.step_s * (1.0 + kOnGrid);
    const bool is_moved = !is_filled && placed.off_s > kOnGrid * result_.step_s + quantum_s();
    placed.kind = is_filled ? Kind::filled : is_moved ? Kind::moved : Kind::measured;
    const std::vector<double>& value = values(c);
    if (c < held_ && (!is_filled || is_gap)) {
      placed.value = value[is_filled ? before : placed.row];
    } else if (!is_filled && !is_moved) {
      placed.value = value[placed.row];
    } else {
      const double weight = span_s > 0.0 ? std::clamp((at - time_s_[before]) / span_s, 0.0, 1.0) : 0.0;
      placed.value = (1.0 - weight) * value[before] + weight * value[after];
    }
    return placed;
  }

  /// Makes each value of a held column the mean until the next grid point, of values held from row to row: what the
  /// input of uneven rows did.
  void average(std::size_t c) {
    const std::vector<std::size_t>& rows = sources_[c].rows;
    const std::vector<double>& value = values(c);
    std::size_t at = 0;
    for (std::size_t k = 0; k < result_.columns[c].size(); ++k) {
      if (std::binary_search(result_.held.begin(), result_.held.end(), k)) continue;
      double from_s = result_.start_s + static_cast<double>(k) * result_.step_s;
      const double to_s = from_s + result_.step_s;
      while (at + 1 < rows.size() && time_s_[rows[at + 1]] <= from_s) ++at;
      double sum = 0.0;
      for (std::size_t i = at; from_s < to_s; ++i) {
        const double until_s = i + 1 < rows.size() ? std::clamp(time_s_[rows[i + 1]], from_s, to_s) : to_s;
        sum += (until_s - from_s) * value[rows[i]];
        from_s = until_s;
      }
      result_.columns[c][k] = sum / result_.step_s;
    }
  }

  /// Rounding of a printed time [s].
  [[nodiscard]] double quantum_s() const { return rows_.has_lines ? std::pow(10.0, -rows_.time_decimals) : 0.0; }

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
    const std::string place = path_.filename().string() + rows_.where(stretch_row_);
    const std::string span =
        rows == 1 ? fmt::format("at {} s", time_text(from_s, kTimeDigits))
                  : fmt::format("{} to {} s", time_text(from_s, kTimeDigits), time_text(to_s, kTimeDigits));
    const char* plural = rows == 1 ? "" : "s";
    Repairs& repairs = repairs_of(kind_);
    repairs.rows += rows;
    repairs.most_s = std::max(repairs.most_s, most_off_s_);
    std::string what;
    switch (kind_) {
      case Kind::moved:
        what = fmt::format("{} row{} up to {:.3g} s off the grid, moved", rows, plural, most_off_s_);
        break;
      case Kind::output_filled:
        what = fmt::format("no output measured, interpolated in {} row{} whose input is kept", rows, plural);
        break;
      case Kind::input_filled:
        what = fmt::format("no input measured, filled in {} row{} whose output is kept", rows, plural);
        break;
      case Kind::filled:
      case Kind::measured:
        what = fmt::format("nothing measured, {} row{} filled", rows, plural);
        break;
    }
    repairs.sentences.push_back(fmt::format("{}: {}: {}", place, span, what));
  }

  /// All of one kind.
  struct Repairs {
    std::vector<std::string> sentences;
    std::size_t rows = 0;
    double most_s = 0.0;
  };

  [[nodiscard]] Repairs& repairs_of(Kind kind) {
    switch (kind) {
      case Kind::output_filled:
        return output_filled_;
      case Kind::input_filled:
        return input_filled_;
      case Kind::filled:
        return filled_;
      case Kind::moved:
      case Kind::measured:
        break;
    }
    return moved_;
  }

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
  std::vector<std::size_t> timed_;  ///< rows of the file with a time and at least one value
  std::vector<Source> sources_;     ///< of each column but the time
  Resampled result_;
  Repairs repeated_;
  Repairs filled_;
  Repairs output_filled_;
  Repairs input_filled_;
  Repairs moved_;
  std::size_t next_row_ = 0;  ///< of the file, see row_at()
  Kind kind_ = Kind::measured;
  std::size_t stretch_from_ = 0;
  std::size_t stretch_row_ = 0;
  double most_off_s_ = 0.0;
};

}  // namespace

double typical_step_s(std::vector<double> steps) { return sound_steps(std::move(steps)).mean; }

Resampled resample(const Rows& rows, std::size_t held, std::optional<double> period_s,
                   const std::filesystem::path& path) {
  return Resampler(rows, held, path).run(period_s);
}

}  // namespace eha::importer
