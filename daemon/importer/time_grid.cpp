// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/time_grid.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "core/time_text.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/importer/clock_text.hpp"
#include "ident/record.hpp"
#include "ident/signal/kept_values.hpp"

namespace eha::importer {
namespace {

/// A double prints exactly with this many digits; more digits carry no information.
constexpr int kMostDecimals = 15;
/// Steps that differ by less than this share are equal: no clock or fit resolves it.
constexpr double kSameStep = 1e-6;
/// Steps from which on rows are missing, of an even clock and of one that scatters.
constexpr double kGap = 1.5;
constexpr double kGapOfScattering = 3.0;

class Grid {
 public:
  Grid(const Rows& table, const std::filesystem::path& path, const Options& options)
      : table_(table), path_(path), options_(options), time_s_(table.columns.front()) {}

  double step_s() {
    const std::size_t rows = time_s_.size();
    if (rows < 2) {
      throw DataError(fmt::format("{}{}: {}, at least two are needed to know the sample period", path_.string(),
                                  rows == 0 ? table_.header_place() : table_.where(0),
                                  rows == 0 ? "no row follows the header" : "only one row follows the header"));
    }
    check_increasing();
    typical_step_s_ = typical_step();
    check_each_step();
    // The step to nine digits: finer than every clock, coarser than rounding noise.
    const double rounded_s = std::stod(fmt::format("{:.9g}", typical_step_s_));
    const double whole_step_s =
        std::stod(fmt::format("{:.{}f}", rounded_s, std::clamp(table_.time_decimals, 0, kMostDecimals)));
    if (whole_step_s > 0.0 && first_off_grid(whole_step_s, 0.5) == rows) return whole_step_s;
    const double mean_step_s = (time_s_.back() - time_s_.front()) / static_cast<double>(rows - 1);
    const double tidy_step_s = std::stod(fmt::format("{:.12g}", mean_step_s));
    // Both the first row and the row looked at may be rounded.
    if (first_off_grid(tidy_step_s, 1.0) == rows) return tidy_step_s;
    // Coarser than rounding: the roundest step that drifts from the rows by less than that over the record.
    const double near_step_s = roundest_step(mean_step_s);
    const std::size_t off = first_off_grid(near_step_s, 1.0, kOnGrid);
    if (off == rows) return near_step_s;
    fail(off,
         fmt::format("time_s is {}, {:.3g} s off an even grid of {:.9g} s steps", time_text(time_s_[off], 9),
                     time_s_[off] - time_s_.front() - static_cast<double>(off) * near_step_s, near_step_s),
         drift(mean_step_s));
  }

 private:
  [[nodiscard]] std::string command(const std::string& extra) const { return command_with(options_, path_, extra); }

  [[noreturn]] void fail(std::size_t row, const std::string& what, const std::string& other = "") const {
    throw DataError(fmt::format("{}{}: {}; a record needs evenly spaced rows: `{}`, or cut it there{}", path_.string(),
                                table_.where(row), what, command("--resample"), other));
  }

  /// The slope of the times of the rows [from, to).
  [[nodiscard]] double fitted_period(std::size_t from, std::size_t to) const {
    const auto rows = static_cast<Eigen::Index>(to - from);
    const Eigen::ArrayXd time_s = Eigen::Map<const Eigen::ArrayXd>(time_s_.data() + from, rows) - time_s_[from];
    const Eigen::ArrayXd place = Eigen::ArrayXd::LinSpaced(rows, -0.5, 0.5) * static_cast<double>(rows - 1);
    return (place * time_s).sum() / place.square().sum();
  }

  /// The longest part of the rows between steps that leave rows out.
  struct Part {
    std::string options;  ///< "--from 31 --to 50"
    std::size_t rows = 0;
    double period_s = 0.0;  ///< of its rows
  };

  /// That part where gaps leave out more rows than a record may have in gaps, and the part has many of the rows.
  /// @param gap  steps from which on rows are left out
  [[nodiscard]] std::optional<Part> part_between_gaps(double gap) const {
    constexpr double kMostInGaps = 0.01;  // of the rows
    constexpr double kWorthIt = 0.4;      // of the rows
    std::size_t begin = 0;
    std::size_t from = 0;
    std::size_t to = 0;  // behind the last
    double missing = 0.0;
    for (std::size_t k = 1; k <= time_s_.size(); ++k) {
      const double steps = k < time_s_.size() ? (time_s_[k] - time_s_[k - 1]) / typical_step_s_ : 2.0 * gap;
      if (steps < gap) continue;
      if (k < time_s_.size() && std::round(steps) > static_cast<double>(ident::kRowsOfGap))
        missing += std::round(steps) - 1.0;
      if (k - begin > to - from) {
        from = begin;
        to = k;
      }
      begin = k;
    }
    const auto rows = static_cast<double>(time_s_.size());
    if (missing <= kMostInGaps * rows || static_cast<double>(to - from) < kWorthIt * rows) return std::nullopt;
    std::string options;
    if (from > 0) options = "--from " + time_text(time_s_[from]);
    if (to < time_s_.size()) options += (options.empty() ? "--to " : " --to ") + time_text(time_s_[to - 1]);
    return Part{options, to - from, fitted_period(from, to)};
  }

  /// A clock that is uneven from row to row: refused with what helps, which depends on what scatters.
  void refuse_jitter(std::size_t row, double allowed_s, const std::string& what) const {
    constexpr std::size_t kFewestRows = 40;
    constexpr double kUnevenSteps = 0.1;  // share of the steps
    constexpr double kWithin = 0.75;      // of a step, off an even grid
    constexpr double kWanders = 0.5;      // of a step, together: a row is missing, or the clock itself wanders
    if (time_s_.size() < kFewestRows) return;
    const auto rows = static_cast<Eigen::Index>(time_s_.size());
    const Eigen::ArrayXd time_s = Eigen::Map<const Eigen::ArrayXd>(time_s_.data(), rows) - time_s_.front();
    const Eigen::ArrayXd steps_s = time_s.tail(rows - 1) - time_s.head(rows - 1);
    const double uneven = ((steps_s - typical_step_s_).abs() > allowed_s).cast<double>().mean();
    if (uneven < kUnevenSteps) return;
    const Eigen::ArrayXd place = Eigen::ArrayXd::LinSpaced(rows, -0.5, 0.5) * static_cast<double>(rows - 1);
    const double period_s = fitted_period(0, time_s_.size());
    const Eigen::ArrayXd off_s = time_s - time_s.mean() - period_s * place;
    const bool is_within = off_s.abs().maxCoeff() <= kWithin * period_s && wander_s(off_s) <= kWanders * period_s;
    const std::string place_text = path_.string() + table_.where(row);
    if (const auto part = is_within ? std::nullopt : part_between_gaps(kGapOfScattering)) {
      throw DataError(fmt::format(
          "{}: {}: {:.0f} % of the steps differ so, and rows are missing; the longest part without, {} of "
          "{} rows, if the rows were sampled evenly, and only their time stamps came early or late: `{}`; "
          "if the times are those of the samples: `{}`",
          place_text, what, 100.0 * uneven, part->rows, time_s_.size(),
          command(fmt::format("--period {:.9g} {}", round_period(part->period_s, time_s_.size()), part->options)),
          command("--resample " + part->options)));
    }
    if (!is_within) {
      throw DataError(fmt::format(
          "{}: {}: {:.0f} % of the steps differ so; if the times are those of the samples, this puts them on "
          "an even grid: `{}`",
          place_text, what, 100.0 * uneven, command("--resample")));
    }
    const double round_s = round_period(period_s, time_s_.size());
    throw DataError(fmt::format(
        "{}: {}: the times scatter by {:.3g} s about an even grid of {:.9g} s, and no row is missing; if the "
        "rows were sampled evenly, and only their time stamps came early or late: `{}`; if the times are "
        "those of the samples: `{}`",
        place_text, what, std::sqrt(off_s.square().mean()), round_s, command(fmt::format("--period {:.9g}", round_s)),
        command("--resample")));
  }

  /// How far the mean over rows that follow one another moves.
  [[nodiscard]] static double wander_s(const Eigen::ArrayXd& off_s) {
    constexpr Eigen::Index kTogether = 20;
    double mean_s = off_s.head(kTogether).mean();
    double least_s = mean_s;
    double greatest_s = mean_s;
    for (Eigen::Index k = kTogether; k < off_s.size(); ++k) {
      mean_s += (off_s[k] - off_s[k - kTogether]) / static_cast<double>(kTogether);
      least_s = std::min(least_s, mean_s);
      greatest_s = std::max(greatest_s, mean_s);
    }
    return greatest_s - least_s;
  }

  /// For times that leave the grid smoothly, as added up in single precision: the mean step.
  [[nodiscard]] std::string drift(double mean_step_s) const {
    constexpr std::size_t kParts = 20;
    constexpr double kSteady = 0.01;  // of the mean step
    const std::size_t rows = time_s_.size() / kParts;
    if (rows < 2) return {};
    for (std::size_t k = 0; k + rows < time_s_.size(); k += rows) {
      const double step_s = (time_s_[k + rows] - time_s_[k]) / static_cast<double>(rows);
      if (std::abs(step_s - mean_step_s) > kSteady * mean_step_s) return {};
    }
    return fmt::format("; or, as the clock only drifts, steadily, take the rows as even, with their mean step: `{}`",
                       command(fmt::format("--period {:.6g}", mean_step_s)));
  }

  /// Value of the last digit printed at a row [s].
  [[nodiscard]] double quantum_s(std::size_t row) const {
    const double magnitude = std::abs(time_s_[row]);
    const double fixed = std::pow(10.0, -table_.time_decimals);
    if (magnitude <= 0.0) return fixed;
    return std::max(fixed, std::pow(10.0, std::floor(std::log10(magnitude)) + 1.0 - table_.time_significant));
  }

  void check_increasing() const {
    refuse_coarse_clock();
    refuse_newest_first();
    for (std::size_t k = 1; k < time_s_.size(); ++k) {
      if (is_restart(k, 0.0) && is_restart(k, typical_step())) refuse_restarts();
      if (!(time_s_[k] > time_s_[k - 1])) {
        fail(k, fmt::format("time_s goes from {:.9g} to {:.9g}: it must increase", time_s_[k - 1], time_s_[k]));
      }
    }
  }

  /// Whether a row has all values of the row before.
  [[nodiscard]] bool keeps_values(std::size_t k) const {
    return std::all_of(table_.columns.begin() + 1, table_.columns.end(), [k](const std::vector<double>& column) {
      return ident::is_same_value(column[k], column[k - 1]);
    });
  }

  /// A clock that shows several rows alike: all rows together tell their period, and resampling would lose most. Rows
  /// that a logger wrote twice are left out by it.
  void refuse_coarse_clock() const {
    constexpr std::size_t kRowsPerRepeat = 10;
    constexpr double kMostlyCopies = 0.9;
    constexpr double kMostAtRest = 0.5;  // of the other rows, which keep their values where nothing moves
    std::size_t repeats = 0;
    std::size_t copies = 0;
    std::size_t at_rest = 0;
    double least_step_s = std::numeric_limits<double>::infinity();
    for (std::size_t k = 1; k < time_s_.size(); ++k) {
      const double step_s = time_s_[k] - time_s_[k - 1];
      if (step_s > 0.0) least_step_s = std::min(least_step_s, step_s);
      const bool is_repeat = !(step_s > 0.0 || step_s < 0.0);
      if (is_repeat) ++repeats;
      if (keeps_values(k)) ++(is_repeat ? copies : at_rest);
    }
    if (kRowsPerRepeat * repeats < time_s_.size()) return;
    const bool are_copies = static_cast<double>(copies) > kMostlyCopies * static_cast<double>(repeats) &&
                            static_cast<double>(at_rest) < kMostAtRest * static_cast<double>(time_s_.size() - repeats);
    if (are_copies && std::isfinite(least_step_s)) {
      throw DataError(fmt::format(
          "{}: {} of {} rows repeat the row before, its time and all its values, as where a logger or a copy "
          "writes each row twice; to leave them out: `{}`",
          path_.string(), copies, time_s_.size(), command("--resample")));
    }
    // The clock goes on by no less, however many digits it has.
    const double shown_s = std::isfinite(least_step_s) ? least_step_s : 0.0;
    RowClock clock;
    for (const double time_s : time_s_) clock.add(time_s, std::max(shown_s, quantum_s(time_s_.size() - 1)));
    const std::optional<RowPeriod> period = clock.period();
    if (!period) return;
    throw DataError(fmt::format("{}: the times repeat, as they are shown more coarsely than the rows follow; {}",
                                path_.string(), period_offer(*period, path_, options_)));
  }

  void refuse_newest_first() const {
    for (std::size_t k = 1; k < time_s_.size(); ++k) {
      if (!(time_s_[k] < time_s_[k - 1])) return;
    }
    throw DataError(fmt::format("{}: the newest row is the first; sort the rows by time", path_.string()));
  }

  /// Whether the time goes back by more than `least_s` at a row and goes on from there.
  [[nodiscard]] bool is_restart(std::size_t k, double least_s) const {
    return k + 1 < time_s_.size() && time_s_[k] < time_s_[k + 1] && time_s_[k + 1] < time_s_[k - 1] &&
           time_s_[k] < time_s_[k - 1] - least_s;
  }

  /// Several records in one file: a command for each.
  [[noreturn]] void refuse_restarts() const {
    constexpr std::array kNames = std::to_array<std::string_view>({"first", "second", "third", "fourth", "fifth"});
    const double least_s = typical_step();
    const double step_s = std::stod(fmt::format("{:.6g}", least_s));
    std::vector<std::size_t> begins{0};
    for (std::size_t k = 1; k < time_s_.size(); ++k) {
      if (is_restart(k, least_s)) begins.push_back(k);
    }
    // Rows are counted, not the clock.
    const auto before = [&](std::size_t row) { return (static_cast<double>(row) - 0.5) * step_s; };
    std::string commands;
    for (std::size_t i = 0; i < std::min(begins.size(), kNames.size()); ++i) {
      std::string extra = fmt::format("--period {:.9g}", step_s);
      if (i > 0) extra += fmt::format(" --from {:.9g}", before(begins[i]));
      if (i + 1 < begins.size()) extra += fmt::format(" --to {:.9g}", before(begins[i + 1]));
      commands += fmt::format("{}the {}: `{}`", i == 0 ? "" : ", ", kNames[i], command(extra));
    }
    const std::size_t row = begins[1];
    throw DataError(
        fmt::format("{}{}: the time goes back from {:.9g} to {:.9g} s, so that another record begins there, "
                    "{} in all; {}",
                    path_.string(), table_.where(row), time_s_[row - 1], time_s_[row], begins.size(), commands));
  }

  [[nodiscard]] double typical_step() const {
    std::vector<double> steps(time_s_.size() - 1);
    for (std::size_t k = 1; k < time_s_.size(); ++k) steps[k - 1] = time_s_[k] - time_s_[k - 1];
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    return *middle;
  }

  void check_each_step() const {
    // The rounding of two times and of the median. Less than half a step, so that a missing row shows however coarsely
    // the times are printed.
    const double slack_s = 2.0 * quantum_s(time_s_.size() - 1) + 2.0 * kOnGrid * typical_step_s_ + rounding_s(1);
    const double allowed_s = std::min(slack_s, 0.499 * typical_step_s_);
    for (std::size_t k = 1; k < time_s_.size(); ++k) {
      const double step_s = time_s_[k] - time_s_[k - 1];
      if (std::abs(step_s - typical_step_s_) > allowed_s) {
        const double ratio = step_s / typical_step_s_;
        const std::string gap =
            ratio > 1.5 ? fmt::format(" ({:.0f} row{} missing)", std::round(ratio) - 1.0, ratio < 2.5 ? "" : "s") : "";
        const std::string what =
            fmt::format("a step of {:.9g} s in time_s, expected {:.9g} s", step_s, typical_step_s_);
        refuse_jitter(k, allowed_s, what);
        if (const auto part = part_between_gaps(kGap)) {
          throw DataError(
              fmt::format("{}{}: {}{}; what the input did there is not known: the longest part without missing rows, "
                          "{} of {} rows: `{}`; or all rows, with the missing ones as not measured: `{}`",
                          path_.string(), table_.where(k), what, gap, part->rows, time_s_.size(),
                          command(part->options), command("--resample")));
        }
        fail(k, what + gap);
      }
    }
  }

  /// Rounding error of this many additions of a step in double precision [s].
  [[nodiscard]] double rounding_s(std::size_t rows) const {
    const double largest = std::max(std::abs(time_s_.front()), std::abs(time_s_.back()));
    return (static_cast<double>(rows) + 4.0) * std::numeric_limits<double>::epsilon() * largest;
  }

  /// First row that is further off t_0 + k step than `quanta` of its last digit, or the number of rows.
  [[nodiscard]] std::size_t first_off_grid(double step_s, double quanta, double share = kSameStep) const {
    for (std::size_t k = 0; k < time_s_.size(); ++k) {
      const double off_s = std::abs(time_s_[k] - time_s_.front() - static_cast<double>(k) * step_s);
      if (off_s > quanta * quantum_s(k) + share * step_s + rounding_s(k)) return k;
    }
    return time_s_.size();
  }

  [[nodiscard]] double roundest_step(double mean_step_s) const {
    const double most_off_s = kOnGrid * mean_step_s / static_cast<double>(time_s_.size());
    for (int digits = 1; digits < kMostStepDigits; ++digits) {
      const double round_s = std::stod(fmt::format("{:.{}e}", mean_step_s, digits - 1));
      if (std::abs(round_s - mean_step_s) <= most_off_s) return round_s;
    }
    return std::stod(fmt::format("{:.12g}", mean_step_s));
  }

  const Rows& table_;
  const std::filesystem::path& path_;
  const Options& options_;
  const std::vector<double>& time_s_;
  double typical_step_s_ = 0.0;
};

}  // namespace

double round_period(double period_s, std::size_t rows) {
  constexpr double kDrift = 0.25;
  for (int digits = 1; digits < kMostStepDigits; ++digits) {
    const double round_s = std::stod(fmt::format("{:.{}e}", period_s, digits - 1));
    if (std::abs(round_s - period_s) * static_cast<double>(rows) <= kDrift * period_s) return round_s;
  }
  return period_s;
}

double even_step_s(const Rows& rows, const std::filesystem::path& path, const Options& options) {
  return Grid(rows, path, options).step_s();
}

}  // namespace eha::importer
