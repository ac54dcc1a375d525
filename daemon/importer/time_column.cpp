// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/time_column.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/importer/clock_text.hpp"
#include "daemon/importer/column_text.hpp"
#include "daemon/importer/column_values.hpp"
#include "daemon/importer/roles.hpp"
#include "daemon/importer/time_grid.hpp"

namespace eha::importer {
namespace {

enum class Rise { any, strict };
bool goes_on(const std::vector<double>& sample, Rise rise = Rise::any) {
  const bool has_rise = rise == Rise::any || (!sample.empty() && sample.front() < sample.back());
  const auto falls = [](double a, double b) { return !(b >= a); };
  return has_rise && std::adjacent_find(sample.begin(), sample.end(), falls) == sample.end();
}

/// Whether every row of a clock differs from the one before.
bool is_fine(const std::vector<double>& sample) {
  const auto stays = [](double a, double b) { return !(b > a); };
  return sample.size() > 1 && std::adjacent_find(sample.begin(), sample.end(), stays) == sample.end();
}

/// How a column that tells the time goes on over the sampled rows.
struct Pace {
  std::size_t column = 0;
  bool has_unit = false;    ///< else it is taken as seconds
  bool is_text = false;     ///< a clock
  bool are_days = false;    ///< of a spreadsheet
  double start = 0.0;       ///< size of the first [s]
  double span = 0.0;        ///< [s]
  double digit = 0.0;       ///< the least step between two rows that differ [s]
  double unevenness = 0.0;  ///< the farthest row from an even grid [steps]

  [[nodiscard]] bool is_regular() const { return unevenness <= kOnGrid; }
};

/// Times of day of a spreadsheet, parts of a day: as seconds the rows would follow by a hundred thousand a second, and
/// begin late.
bool are_parts_of_a_day(const std::vector<double>& sample) {
  constexpr double kEarliest = 0.01;
  constexpr double kLongestStep = 1e-5;
  const double span = sample.back() - sample.front();
  return sample.front() > kEarliest && sample.back() < 1.0 && span > 0.0 && span < sample.front() &&
         span <= kLongestStep * static_cast<double>(sample.size() - 1);
}

/// Numbers of a spreadsheet's dates, or MATLAB's, or times of day.
bool are_days(const Column& column) {
  const auto is_date = [](double x) { return (x > 20'000.0 && x < 80'000.0) || (x > 700'000.0 && x < 800'000.0); };
  const std::vector<double>& sample = column.sample;
  if (column.is_clock || !column.unit.empty() || sample.size() < 2) return false;
  if (are_parts_of_a_day(sample)) return true;
  return is_date(sample.front()) && is_date(sample.back()) &&
         std::any_of(sample.begin(), sample.end(), [](double x) { return std::abs(x - std::round(x)) > 0.0; });
}

/// @param column  its sample ascends, and its last value is above the first
Pace pace_of(std::size_t at, const Column& column) {
  constexpr double kDay_s = 86400.0;
  const std::vector<double>& sample = column.sample;
  Pace pace{.column = at, .is_text = !column.is_number, .are_days = are_days(column)};
  const double unit_s = pace.are_days ? kDay_s : column.is_number ? seconds_in(column.unit).value_or(1.0) : 1.0;
  pace.has_unit = pace.is_text || pace.are_days || !column.unit.empty();
  pace.start = std::abs(sample.front()) * unit_s;
  pace.span = (sample.back() - sample.front()) * unit_s;
  pace.digit = pace.span;
  const double step = (sample.back() - sample.front()) / static_cast<double>(sample.size() - 1);
  for (std::size_t k = 1; k < sample.size(); ++k) {
    const double off = sample[k] - sample.front() - step * static_cast<double>(k);
    pace.unevenness = std::max(pace.unevenness, std::abs(off) / step);
    const double rise = (sample[k] - sample[k - 1]) * unit_s;
    if (rise > 0.0) pace.digit = std::min(pace.digit, rise);
  }
  return pace;
}

/// Whether two may tell one time; a column without a unit may be in any.
bool agree(const Pace& a, const Pace& b) {
  constexpr double kSameSpan = 0.02;
  constexpr std::array kUnits_s = {1e-9, 1e-6, 1e-3, 60.0, 3600.0, 86400.0};
  // A clock is known to its last digit at either end.
  const double off = std::abs(a.span - b.span);
  if (off <= kSameSpan * std::min(a.span, b.span) || off <= 1.05 * std::max(a.digit, b.digit)) return true;
  if (a.has_unit == b.has_unit) return false;
  const double ratio = a.has_unit ? a.span / b.span : b.span / a.span;
  return std::any_of(kUnits_s.begin(), kUnits_s.end(),
                     [&](double unit_s) { return std::abs(ratio / unit_s - 1.0) <= kSameSpan; });
}

class TimeFinder {
 public:
  TimeFinder(Table& table, const std::filesystem::path& path, const Options& options, const std::vector<Hints>& hints)
      : table_(table), columns_(table.columns()), path_(path), options_(options), hints_(hints) {}

  TimeChoice choice(const std::vector<std::optional<std::size_t>>& taken) const {
    const Claims claims = claims_of(taken);
    const std::vector<std::size_t> best = strongest(claims.named);
    if (best.size() > 1 && !are_of_one_table(best)) ask(best);
    std::vector<std::size_t> rivals = named_rivals(claims.named);
    // A clock that shows several rows alike only confirms another time.
    const bool has_time = !rivals.empty() || std::any_of(claims.clocks.begin(), claims.clocks.end(),
                                                         [&](std::size_t i) { return is_fine(columns_[i].sample); });
    if (has_time) rivals.insert(rivals.end(), claims.clocks.begin(), claims.clocks.end());
    std::sort(rivals.begin(), rivals.end());
    if (rivals.size() > 1) return one_of(rivals);
    if (!rivals.empty()) return {.column = rivals.front()};
    if (best.size() > 1) ask(best);
    if (!best.empty()) return {.column = best.front()};
    if (!claims.even.empty()) return {.column = claims.even.front()};
    return {.column = last_resort(claims)};
  }

  void refuse_days(std::size_t at) const {
    constexpr double kFastestStep = 7e-4;  // a minute in days
    const std::vector<double>& sample = columns_[at].sample;
    if (!are_days(columns_[at]) ||
        !(sample.back() - sample.front() <= kFastestStep * static_cast<double>(sample.size() - 1)))
      return;
    fail(
        fmt::format("column {} holds numbers such as {:.9g}: days of a spreadsheet, or seconds? For days, {}; for "
                    "seconds: `{}`",
                    described(columns_, at), sample.front(), told_by(at), command(fmt::format("--time {}", at + 1))));
  }

 private:
  /// Columns by what makes them a time.
  struct Claims {
    std::vector<std::size_t> named;     ///< by name or unit
    std::vector<std::size_t> even;      ///< numbers that rise evenly
    std::vector<std::size_t> counting;  ///< 0, 1, 2
    std::vector<std::size_t> clocks;    ///< that go on
    std::optional<std::size_t> clock;   ///< any clock
  };

  [[noreturn]] void fail(const std::string& what) const {
    throw DataError(fmt::format("{}: {}", path_.string(), what));
  }
  [[nodiscard]] std::string command(const std::string& extra) const { return command_with(options_, path_, extra); }

  [[nodiscard]] Claims claims_of(const std::vector<std::optional<std::size_t>>& taken) const {
    Claims claims;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (std::find(taken.begin(), taken.end(), std::optional(i)) != taken.end()) continue;
      const Column& column = columns_[i];
      if (!column.is_number) {
        if (column.is_clock) claims.clock = i;
        if (column.is_clock && goes_on(column.sample, Rise::strict)) claims.clocks.push_back(i);
        continue;
      }
      const bool fits =
          std::all_of(taken.begin(), taken.end(), [&](auto t) { return !t || column.rows == columns_[*t].rows; });
      if (!fits || hints_[i].is_temperature) continue;
      if (hints_[i].is_letter_t && !goes_on(column.sample, Rise::strict)) continue;
      if (hints_[i].time > 0) {
        claims.named.push_back(i);
      } else if (counts_rows(column.sample)) {
        claims.counting.push_back(i);
      } else if (hints_[i].input == 0 && hints_[i].output == 0 && increases_evenly(column.sample)) {
        claims.even.push_back(i);
      }
    }
    // Beside times of day the milliseconds of each second may stand in a column of their own, and T is a temperature.
    if (claims.clock) {
      std::erase_if(claims.named, [&](std::size_t i) { return !goes_on(columns_[i].sample) || hints_[i].is_letter_t; });
    }
    return claims;
  }

  [[nodiscard]] std::vector<std::size_t> strongest(const std::vector<std::size_t>& of) const {
    std::vector<std::size_t> best;
    for (const std::size_t i : of) {
      if (!best.empty() && hints_[i].time < hints_[best.front()].time) continue;
      if (!best.empty() && hints_[i].time > hints_[best.front()].time) best.clear();
      best.push_back(i);
    }
    return best;
  }

  /// Columns of several structs or groups, or of different lengths, are several records.
  [[nodiscard]] bool are_of_one_table(const std::vector<std::size_t>& found) const {
    return std::all_of(found.begin(), found.end(), [&](std::size_t i) {
      return columns_[i].rows == columns_[found.front()].rows &&
             prefix_of(columns_[i].label) == prefix_of(columns_[found.front()].label);
    });
  }

  /// Those that go on, by their name where one is named; a column that only counts its rows is none beside another.
  [[nodiscard]] std::vector<std::size_t> named_rivals(const std::vector<std::size_t>& named) const {
    constexpr int kByName = 2;
    std::vector<std::size_t> rivals;
    for (const std::size_t i : named) {
      if (goes_on(columns_[i].sample, Rise::strict)) rivals.push_back(i);
    }
    const auto keep_others = [&](const auto& is_weak) {
      if (!std::all_of(rivals.begin(), rivals.end(), is_weak)) std::erase_if(rivals, is_weak);
    };
    keep_others([&](std::size_t i) { return hints_[i].time < kByName; });
    keep_others([&](std::size_t i) { return columns_[i].unit.empty() && counts_rows(columns_[i].sample); });
    return are_of_one_table(rivals) ? rivals : std::vector<std::size_t>();
  }

  /// "time 1, ch 1, time 2, ch 2": a value behind every time.
  [[nodiscard]] bool are_of_channels(const std::vector<std::size_t>& rivals) const {
    for (std::size_t r = 0; r < rivals.size(); ++r) {
      const std::size_t end = r + 1 < rivals.size() ? rivals[r + 1] : columns_.size();
      if (!columns_[rivals[r]].is_number || end == rivals[r] + 1 || !columns_[rivals[r] + 1].is_number) return false;
    }
    return std::none_of(columns_.begin(), columns_.begin() + static_cast<std::ptrdiff_t>(rivals.front()),
                        [](const Column& column) { return column.is_number; });
  }

  [[nodiscard]] TimeChoice one_of(const std::vector<std::size_t>& rivals) const {
    if (are_of_channels(rivals)) return {.column = rivals.front(), .of_channels = rivals};
    std::vector<Pace> paces;
    for (const std::size_t i : rivals) paces.push_back(pace_of(i, columns_[i]));
    const auto is_better = [&](const Pace& a, const Pace& b) {
      if (a.are_days != b.are_days) return b.are_days;
      if (a.is_regular() != b.is_regular()) return a.is_regular();
      if (!a.is_regular() && std::abs(a.unevenness - b.unevenness) > kOnGrid) return a.unevenness < b.unevenness;
      if (a.has_unit != b.has_unit) return a.has_unit;
      if (a.is_text != b.is_text) return b.is_text;
      return a.start < b.start;
    };
    const Pace& finest = *std::min_element(paces.begin(), paces.end(), is_better);
    std::string note;
    for (const Pace& pace : paces) {
      if (pace.column == finest.column) continue;
      if (!agree(pace, finest)) refuse_contradiction(finest, pace);
      note += fmt::format("{}{} {}", note.empty() ? "" : ", ", described(columns_, pace.column),
                          pace.unevenness > finest.unevenness + kOnGrid ? "is coarser" : "agrees");
    }
    return {.column = finest.column, .note = std::move(note)};
  }

  [[noreturn]] void refuse_contradiction(const Pace& finest, const Pace& other) const {
    const auto said = [&](const Pace& pace) {
      return fmt::format("{} rises by {:.6g}{} over the first {} rows", described(columns_, pace.column), pace.span,
                         pace.has_unit ? " s" : "", columns_[pace.column].sample.size());
    };
    const auto mend = [&](const Pace& pace) { return command(fmt::format("--time {}", pace.column + 1)); };
    fail(
        fmt::format("two columns tell the time and contradict one another: {}, {}; for the first: `{}`; for the "
                    "second: `{}`",
                    said(finest), said(other), mend(finest), mend(other)));
  }

  [[nodiscard]] std::optional<std::size_t> last_resort(const Claims& claims) const {
    if (claims.clock) {
      const std::string& text = columns_[*claims.clock].sampled_text;
      fail(fmt::format("column {} holds {} such as \"{}\", which do not tell the rows apart; {}",
                       described(columns_, *claims.clock),
                       text.find(':') == std::string::npos ? "times with their unit" : "dates or times of day",
                       readable(text, kLongestShown), told_by(*claims.clock)));
    }
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i].is_number || !is_clock_of_minutes(columns_[i].sampled_text)) continue;
      fail(
          fmt::format("column {} shows minutes only, such as \"{}\"; {}format its cells to show seconds and parts of "
                      "them (hh:mm:ss.000) and export again",
                      described(columns_, i), readable(columns_[i].sampled_text, kLongestShown), told_by_minutes(i)));
    }
    if (table_.stated_period()) return std::nullopt;
    if (!claims.counting.empty()) {
      const std::size_t i = claims.counting.front();
      if (table_.told_period_s())
        fail(fmt::format("column {} numbers the rows; {}", described(columns_, i), period_asked()));
      fail(fmt::format(
          "column {} counts 0, 1, 2: seconds, or the numbers of the rows? For seconds: `{}`; for the numbers "
          "of rows, with the sample period in seconds: `{}`",
          described(columns_, i), command(fmt::format("--time {}", i + 1)), command("--period SECONDS")));
    }
    fail(fmt::format("no column of times; columns: {}; {}", listed(columns_), period_asked()));
  }

  /// Asks for the sample period, or offers what stands above the rows.
  [[nodiscard]] std::string period_asked() const {
    const std::optional<double> told_s = table_.told_period_s();
    if (!told_s) return fmt::format("with the sample period in seconds: `{}`", command("--period SECONDS"));
    return fmt::format("the lines above the rows say one every {:.9g} s: `{}`", *told_s,
                       command(fmt::format("--period {:.9g}", *told_s)));
  }

  /// What the rows of a clock tell of the sample period, with the command that takes it.
  [[nodiscard]] std::string told_by(std::size_t column) const {
    const std::optional<RowPeriod> period = table_.period_of_rows(column);
    return period ? period_offer(*period, path_, options_)
                  : fmt::format("with the sample period in seconds: `{}`", command("--period SECONDS"));
  }

  /// The same of a clock that shows hours and minutes, or minutes and seconds: "... or ", before another way out.
  [[nodiscard]] std::string told_by_minutes(std::size_t column) const {
    const std::string& text = columns_[column].sampled_text;
    const std::optional<RowPeriod> period = table_.told_period_s() ? std::nullopt : table_.period_of_rows(column);
    if (!period) return period_asked() + ", or ";
    constexpr double kMinute = 1.0 / 60.0;
    const bool has_date = text.find(':') > 2;
    if (has_date) return fmt::format("{}; or ", period_offer(*period, path_, options_));
    const bool is_part = period->first_row > 0 || period->is_part;
    return fmt::format("if these are hours and minutes: `{}`; if minutes and seconds: `{}`{}; or ",
                       command(period_options(*period)), command(period_options(*period, kMinute)),
                       is_part ? fmt::format(" (the longest part without a pause, {} rows)", period->rows) : "");
  }

  /// Several columns have equal claims.
  [[noreturn]] void ask(const std::vector<std::size_t>& found) const {
    std::vector<std::string> names;
    for (const std::size_t i : found) names.push_back(described(columns_, i));
    fail(fmt::format("which column is the time? {} may be; columns: {}. For the first of them: `{}`",
                     fmt::join(names, " or "), listed(columns_), command(fmt::format("--time {}", found.front() + 1))));
  }

  Table& table_;
  const std::vector<Column>& columns_;
  const std::filesystem::path& path_;
  const Options& options_;
  const std::vector<Hints>& hints_;
};

}  // namespace

TimeChoice find_time_column(Table& table, const std::filesystem::path& path, const Options& options,
                            const std::vector<Hints>& hints, const std::vector<std::optional<std::size_t>>& taken) {
  return TimeFinder(table, path, options, hints).choice(taken);
}

void refuse_days(Table& table, std::size_t column, const std::filesystem::path& path, const Options& options) {
  TimeFinder(table, path, options, {}).refuse_days(column);
}

}  // namespace eha::importer
