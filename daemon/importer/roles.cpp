// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/roles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <system_error>

#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "core/shell_word.hpp"
#include "core/text.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/column_text.hpp"
#include "daemon/importer/column_values.hpp"
#include "daemon/importer/own_times.hpp"
#include "daemon/importer/row_for_each_value.hpp"
#include "daemon/importer/time_column.hpp"
#include "daemon/importer/time_grid.hpp"

namespace eha::importer {
namespace {

/// A column that counts this many rows or more numbers them, whatever its name.
constexpr std::size_t kFewestCounted = 20;

/// "/group/u", "group.u" and "group/u" are one name.
std::string comparable(std::string_view name) {
  if (!name.empty() && name.front() == '/') name.remove_prefix(1);
  std::string result(name);
  std::replace(result.begin(), result.end(), '/', '.');
  return result;
}

/// For the example of a question: a place before a pressure, a temperature after both, and a set point last, of
/// whatever it is one.
int rank_as_output(const Hints& hints) {
  if (hints.is_set_point || hints.is_demand_as_input) return -4;
  if (hints.is_ambient) return -3;
  if (hints.names_temperature) return -2;
  if (hints.is_valve_feedback) return 0;
  if (hints.output > hints.input) return 4;
  if (hints.is_pressure) return 3;
  return hints.input > hints.output ? 1 : 2;
}

int rank_as_input(const Hints& hints) {
  if (hints.is_ambient) return -3;
  if (hints.names_temperature) return -2;
  if (hints.is_set_point || hints.is_demand_as_input) return -1;
  if (hints.input > hints.output) return 4;
  if (hints.is_pressure) return 1;
  return hints.output > hints.input ? 2 : 3;
}

class Finder {
 public:
  Finder(Table& table, const std::filesystem::path& path, const Options& options)
      : table_(table), columns_(table.columns()), path_(path.string()), file_(path), options_(options) {
    for (const Column& column : columns_) hints_.push_back(hints_of(column.name, column.unit));
  }

  Roles record() {
    Roles roles;
    if (table_.is_record_format() && !options_.time && !options_.input && !options_.output && !options_.period_s) {
      if (columns_.size() < 3) {
        throw DataError(fmt::format(
            "{}: got {} column{}; expected a header of three columns such as time_s,voltage_V,displacement_in",
            table_.place(), columns_.size(), columns_.size() == 1 ? "" : "s"));
      }
      const bool has_filled = columns_.size() == 4 && columns_[3].name == kFilledColumn;
      if (columns_.size() == 3 || has_filled) {
        require_names();
        roles.time = 0;
        roles.input = 1;
        roles.output = 2;
        if (has_filled) roles.filled = 3;
        return roles;
      }
    }
    const auto input = chosen("--input", options_.input);
    const auto output = chosen("--output", options_.output);
    find_time(roles, {input, output});
    find_filled(roles);
    choose_pair(roles, input, output);
    take_own_times(roles);
    roles.time_unit_assumed = is_unit_assumed(roles);
    return roles;
  }

  Roles input(const std::string& unit) {
    Roles roles;
    const auto input = chosen("--input", options_.input);
    find_time(roles, {input});
    if (input) {
      roles.input = *input;
    } else {
      roles.input = input_in(unit, candidates(roles, {}, 1));
    }
    if (!times_.empty() && roles.time) roles.time = time_before(roles.input);
    roles.time_unit_assumed = is_unit_assumed(roles);
    const Column& column = columns_[roles.input];
    if (!unit.empty() && !column.unit.empty() && !unit_factor(column.unit, unit)) {
      fail(
          fmt::format("column {} is in {}, the model's input is in {}; give the input in {}, in a column whose header "
                      "says so (such as u_{})",
                      described(columns_, roles.input), column.unit, unit, unit, unit));
    }
    return roles;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw DataError(fmt::format("{}: {}", path_, what)); }

  [[nodiscard]] std::string list() const { return listed(columns_); }

  [[nodiscard]] std::string thousands() const {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const std::string& text = columns_[i].sampled_text;
      const bool has_both = text.find(',') != std::string::npos && text.find('.') != std::string::npos;
      if (!has_both || text.find_first_not_of("0123456789.,+-") != std::string::npos) continue;
      return fmt::format("; {} has thousands separators (\"{}\"): export it without", described(columns_, i), text);
    }
    return {};
  }

  /// A scope writes a file for each channel.
  [[nodiscard]] std::string two_files(const std::vector<std::size_t>& left) const {
    const auto form = table_.text_form();
    if (left.size() != 1 || !form || form->delimiter == ' ') return {};
    const std::string both = file_.stem().string() + "-both.csv";
    return fmt::format(
        "; where the other one is in a file of its own: `paste -d'{}' {} OTHER | tr -d '\\r' > {}`, then "
        "`{}`",
        form->delimiter == '\t' ? "\\t" : std::string(1, form->delimiter), shell_word(path_), shell_word(both),
        command_on(options_, file_, both));
  }

  /// Names in messages and in the files written must tell the columns apart.
  void require_names() const {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i].label.empty()) {
        throw DataError(
            fmt::format("{}: column {} of the header has no name; expected a header of three columns such as "
                        "time_s,voltage_V,displacement_in",
                        table_.place(), i + 1));
      }
      for (std::size_t k = 0; k < i; ++k) {
        if (columns_[i].label != columns_[k].label) continue;
        throw DataError(fmt::format("{}: two columns are named \"{}\"; choose by number: `{}`", table_.place(),
                                    readable(columns_[i].label, kLongestShown),
                                    command("--time 1 --input 2 --output 3")));
      }
    }
  }

  [[nodiscard]] std::string command(const std::string& extra) const { return command_with(options_, file_, extra); }

  /// The column that an option names.
  [[nodiscard]] std::optional<std::size_t> chosen(const char* option, const std::optional<std::string>& text) const {
    if (!text) return std::nullopt;
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (comparable(columns_[i].label) == comparable(*text)) found.push_back(i);
    }
    // Before a name without its unit: of "Time (s),1 (VOLT),2 (VOLT)", 2 is the second column, as every message has it.
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), number);
    if (found.empty() && error == std::errc() && end == text->data() + text->size()) {
      if (number >= 1 && number <= columns_.size()) found.push_back(number - 1);
    }
    for (std::size_t i = 0; found.empty() && i < columns_.size(); ++i) {
      if (comparable(columns_[i].name) == comparable(*text) && !text->empty()) found.push_back(i);
    }
    if (found.empty()) {
      throw UsageError(fmt::format("{} {}: {} has no such column; it has {}{}", option, readable(*text, kLongestShown),
                                   path_, list(), named_folder(option)));
    }
    if (found.size() > 1) {
      throw UsageError(fmt::format("{} {}: {} columns of {} have that name; give the number, such as {} {}", option,
                                   readable(*text, kLongestShown), found.size(), path_, option, found.front() + 1));
    }
    const bool is_clock = std::string_view(option) == "--time" && columns_[found.front()].is_clock;
    if (!columns_[found.front()].is_number && !is_clock) {
      throw UsageError(fmt::format("{} {}: that column of {} is text, such as \"{}\"", option,
                                   readable(*text, kLongestShown), path_,
                                   readable(columns_[found.front()].sampled_text, kLongestShown)));
    }
    return found.front();
  }

  /// --output was once the folder of the models, which is -o alone.
  static const char* named_folder(std::string_view option) {
    return option == "--output" ? "; -o names the file or folder to write" : "";
  }

  /// Columns of different lengths do not belong to one record.
  [[nodiscard]] bool belong_together(std::size_t a, std::size_t b) const {
    return columns_[a].rows == columns_[b].rows;
  }

  void find_time(Roles& roles, const std::vector<std::optional<std::size_t>>& taken) {
    roles.period_s = options_.period_s;
    if (options_.time) {
      roles.time = chosen("--time", options_.time);
    } else if (!options_.period_s) {
      TimeChoice choice = find_time_column(table_, file_, options_, hints_, taken);
      roles.time = choice.column;
      roles.time_note = std::move(choice.note);
      times_ = std::move(choice.of_channels);
    }
    if (!roles.time && !roles.period_s) {
      const auto stated = table_.stated_period();
      roles.period_s = stated->step_s;
      roles.period_name = stated->name;
    }
    replaced_time_ = roles.time;
    // --period replaces the column; with --resample it is that of the new rows.
    if (options_.period_s && !options_.resample) roles.replaced_time = std::exchange(roles.time, std::nullopt);
    if (options_.period_s && !options_.time) roles.replaced_time = replaced_time_ = clock_without_name(taken);
    if (roles.time && !options_.time) refuse_days(table_, *roles.time, file_, options_);
  }

  /// The first column that rises evenly and has no name, where enough others are left; none without one.
  [[nodiscard]] std::optional<std::size_t> clock_without_name(
      const std::vector<std::optional<std::size_t>>& taken) const {
    std::vector<std::size_t> free;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const bool is_taken = std::find(taken.begin(), taken.end(), std::optional(i)) != taken.end();
      if (columns_[i].is_number && !is_taken) free.push_back(i);
    }
    if (free.size() <= static_cast<std::size_t>(std::count(taken.begin(), taken.end(), std::nullopt))) return {};
    const auto is_named_clock = [](const Hints& hints) { return hints.time > 0; };
    if (std::any_of(hints_.begin(), hints_.end(), is_named_clock)) return {};
    const auto found = std::find_if(free.begin(), free.end(), [&](std::size_t i) {
      const Hints& hints = hints_[i];
      return hints.input == 0 && hints.output == 0 && !hints.is_temperature && increases_evenly(columns_[i].sample);
    });
    return found == free.end() ? std::nullopt : std::optional(*found);
  }

  template <typename Strength>
  static std::vector<std::size_t> strongest(const std::vector<std::size_t>& of, const Strength& strength) {
    std::vector<std::size_t> best;
    for (const std::size_t i : of) {
      if (!best.empty() && strength(i) < strength(best.front())) continue;
      if (!best.empty() && strength(i) > strength(best.front())) best.clear();
      best.push_back(i);
    }
    return best;
  }

  void find_filled(Roles& roles) const {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i].label == kFilledColumn && columns_[i].is_number) roles.filled = i;
    }
  }

  /// Columns of numbers that may be input or output.
  [[nodiscard]] std::vector<std::size_t> candidates(const Roles& roles,
                                                    const std::vector<std::optional<std::size_t>>& taken,
                                                    std::size_t needed) const {
    std::vector<std::size_t> found;
    std::vector<std::size_t> spare;
    std::vector<std::size_t> counting;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const bool is_taken = std::find(taken.begin(), taken.end(), std::optional(i)) != taken.end();
      if (is_taken || !columns_[i].is_number || replaced_time_ == i || roles.filled == i) continue;
      if (roles.time && !belong_together(i, *roles.time)) continue;
      if (hints_[i].time > 0 && hints_[i].input == 0 && hints_[i].output == 0) continue;
      const bool numbers_rows =
          counts_rows(columns_[i].sample) && (hints_[i].index > 0 || columns_[i].sample.size() >= kFewestCounted);
      const bool is_spare = hints_[i].is_beside || hints_[i].is_valve_feedback;
      (numbers_rows ? counting : is_spare ? spare : found).push_back(i);
    }
    // A column that counts is no row number where nothing else is left: it may be a ramp.
    for (const std::vector<std::size_t>& more : {spare, counting}) {
      if (found.size() < needed) found.insert(found.end(), more.begin(), more.end());
    }
    std::sort(found.begin(), found.end());
    // Of several structs or groups, those of the time's.
    if (roles.time) {
      std::vector<std::size_t> beside;
      for (const std::size_t i : found) {
        if (prefix_of(columns_[i].label) == prefix_of(columns_[*roles.time].label)) beside.push_back(i);
      }
      if (beside.size() >= needed) return beside;
    }
    return found;
  }

  void choose_pair(Roles& roles, std::optional<std::size_t> input, std::optional<std::size_t> output) const {
    if (input && output && *input == *output) {
      throw UsageError(fmt::format("--input {} and --output {} are one column of {}, {}; it has {}",
                                   readable(*options_.input, kLongestShown), readable(*options_.output, kLongestShown),
                                   path_, described(columns_, *input), list()));
    }
    const std::size_t missing = (input ? 0 : 1) + (output ? 0 : 1);
    const std::vector<std::size_t> left = candidates(roles, {input, output}, missing);
    if (left.size() < missing) {
      fail(fmt::format("expected a column each of input and output; columns: {}{}{}", list(),
                       roles.time ? fmt::format(", of which {} is the time", *roles.time + 1) : "", thousands()) +
           (left.size() == 1 && roles.time ? row_for_each_value(table_, *roles.time, left.front(), file_, options_)
                                           : std::string()) +
           two_files(left));
    }
    // Of two in volts the set point is not what the controller made of it.
    const auto input_strength = [&](std::size_t i) {
      return 2 * (hints_[i].input - hints_[i].output) - (hints_[i].is_demand_as_input ? 1 : 0);
    };
    const auto output_strength = [&](std::size_t i) {
      return 2 * (hints_[i].output - hints_[i].input) - (hints_[i].is_demand_as_input ? 1 : 0);
    };
    std::optional<std::size_t> best_input = input ? input : only(strongest(left, input_strength), input_strength);
    std::optional<std::size_t> best_output = output ? output : only(strongest(left, output_strength), output_strength);
    const bool is_one_pair = left.size() == missing;
    if (is_one_pair && missing == 1) (input ? best_output : best_input) = left.front();
    if (is_one_pair && missing == 2) {
      const auto other = [&](std::size_t i) { return left.front() == i ? left.back() : left.front(); };
      if (best_input && !best_output) best_output = other(*best_input);
      if (best_output && !best_input) best_input = other(*best_output);
      // Two nameless columns: in the order of a record. Two of one kind: that would be a mere guess.
      const bool are_silent = strength_sum(left) == 0;
      if (!best_input && !best_output && are_silent) {
        best_input = left.front();
        best_output = left.back();
      }
    }
    // A set point is what the rod was to do, not what it did; what a valve reports is neither. With one column left
    // that an option made the only choice there is nothing to ask.
    const bool is_of_valve = !output && best_output && hints_[*best_output].is_valve_feedback && left.size() > 1;
    const bool is_doubtful = (!input && best_input && hints_[*best_input].is_beside) ||
                             (!output && best_output && hints_[*best_output].is_set_point);
    if (is_of_valve) ask(roles, left, best_input, std::nullopt);
    if (is_doubtful || !best_input || !best_output || *best_input == *best_output)
      ask(roles, left, best_input, best_output);
    roles.input = *best_input;
    roles.output = *best_output;
    roles.by_order = input_strength(roles.input) <= input_strength(*roles.output);
  }

  [[nodiscard]] bool is_unit_assumed(const Roles& roles) const {
    return roles.time && !columns_[*roles.time].is_clock && columns_[*roles.time].unit.empty() &&
           !epoch_unit_s(columns_[*roles.time]);
  }

  /// Of channels with a time each the one that stands before a column.
  [[nodiscard]] std::size_t time_before(std::size_t column) const {
    const auto behind = std::upper_bound(times_.begin(), times_.end(), column);
    return behind == times_.begin() ? times_.front() : *std::prev(behind);
  }

  /// Of channels with a time each the input's is taken; the output's has to be on the same grid, of which the first
  /// rows tell here.
  void take_own_times(Roles& roles) const {
    if (times_.empty() || !roles.time) return;
    roles.time = time_before(roles.input);
    const std::size_t other = time_before(*roles.output);
    if (other == *roles.time) return;
    roles.output_time = other;
    const auto step_s = [&](std::size_t column, double unit_s) {
      const std::vector<double>& sample = columns_[column].sample;
      return (sample.back() - sample.front()) / static_cast<double>(sample.size() - 1) * unit_s;
    };
    const double input_step_s = step_s(*roles.time, time_unit_s(columns_[*roles.time], file_, options_));
    const double output_step_s = step_s(other, output_time_unit_s(columns_, roles, file_, options_));
    if (std::abs(input_step_s - output_step_s) <= kOnGrid * input_step_s) return;
    refuse_two_grids(table_, {*roles.time, roles.input}, {other, *roles.output},
                     fmt::format("their steps are {:.6g} s and {:.6g} s", input_step_s, output_step_s), file_,
                     options_);
  }

  [[nodiscard]] int strength_sum(const std::vector<std::size_t>& of) const {
    int sum = 0;
    for (const std::size_t i : of) sum += hints_[i].input + hints_[i].output;
    return sum;
  }

  template <typename Strength>
  static std::optional<std::size_t> only(const std::vector<std::size_t>& best, const Strength& strength) {
    if (best.size() != 1 || strength(best.front()) <= 0) return std::nullopt;
    return best.front();
  }

  /// Says of a column that it is no motion of the rod, though its name is one of a measured signal.
  [[nodiscard]] std::string of_valve(const std::vector<std::size_t>& left) const {
    const auto found =
        std::find_if(left.begin(), left.end(), [&](std::size_t i) { return hints_[i].is_valve_feedback; });
    if (found == left.end()) return {};
    return fmt::format(" By its name {} is what the valve reports of itself, and not what it moves.",
                       described(columns_, *found));
  }

  [[noreturn]] void ask(const Roles& roles, const std::vector<std::size_t>& left, std::optional<std::size_t> input,
                        std::optional<std::size_t> output) const {
    // An example that works: what is known, and for the rest the likeliest columns, the first of equal ones.
    if (input && output && *input == *output) output.reset();
    const auto next_free = [&](std::optional<std::size_t> taken, const auto& rank) {
      const auto is_filled = [&](std::size_t i) {
        const std::vector<double>& sample = columns_[i].sample;
        const auto missing = std::count_if(sample.begin(), sample.end(), [](double x) { return std::isnan(x); });
        return 2 * missing <= static_cast<std::ptrdiff_t>(sample.size());
      };
      std::vector<std::size_t> free;
      std::copy_if(left.begin(), left.end(), std::back_inserter(free), [&](std::size_t i) { return taken != i; });
      return *std::max_element(free.begin(), free.end(), [&](std::size_t a, std::size_t b) {
        return std::pair(is_filled(a), rank(a)) < std::pair(is_filled(b), rank(b));
      });
    };
    if (!input) {
      input = next_free(output, [&](std::size_t i) { return std::pair(rank_as_input(hints_[i]), is_held(i)); });
    }
    if (!output) {
      // As in a record the output stands behind its input.
      output = next_free(input, [&](std::size_t i) { return std::pair(rank_as_output(hints_[i]), i > *input); });
    }
    std::string extra;
    if (roles.time && !options_.time && times_.empty()) extra += fmt::format("--time {} ", *roles.time + 1);
    if (!options_.input) extra += fmt::format("--input {} ", *input + 1);
    if (!options_.output) extra += fmt::format("--output {} ", *output + 1);
    extra.pop_back();
    Options answer = options_;
    if (roles.time && !options_.time && times_.empty()) answer.time = std::to_string(*roles.time + 1);
    if (!options_.input) answer.input = std::to_string(*input + 1);
    if (!options_.output) answer.output = std::to_string(*output + 1);
    throw ColumnsAsked(fmt::format("{}: which columns are input and output? It has {} columns: {}.{}", table_.place(),
                                   columns_.size(), list(), of_valve(left)),
                       std::move(answer), command(extra));
  }

  /// Whether a column keeps its value in most rows, and moves: a command that steps.
  [[nodiscard]] bool is_held(std::size_t column) const {
    const std::vector<double>& sample = columns_[column].sample;
    std::size_t kept = 0;
    for (std::size_t k = 1; k < sample.size(); ++k) kept += sample[k] == sample[k - 1] ? 1 : 0;
    if (2 * kept <= sample.size() || kept + 1 >= sample.size()) return false;
    // A temperature that creeps by its last digit is none.
    constexpr double kLeastMove = 0.05;  // of its greatest value
    const auto [least, greatest] = std::minmax_element(sample.begin(), sample.end());
    return *greatest - *least > kLeastMove * std::max(std::abs(*least), std::abs(*greatest));
  }

  [[nodiscard]] std::size_t input_in(const std::string& unit, const std::vector<std::size_t>& left) const {
    if (left.empty()) fail(fmt::format("no column of inputs; columns: {}", list()));
    std::vector<std::size_t> fitting;
    std::copy_if(left.begin(), left.end(), std::back_inserter(fitting),
                 [&](std::size_t i) { return !unit.empty() && columns_[i].unit == unit; });
    if (fitting.empty()) {
      std::copy_if(left.begin(), left.end(), std::back_inserter(fitting),
                   [&](std::size_t i) { return !unit.empty() && unit_factor(columns_[i].unit, unit); });
    }
    if (fitting.size() == 1) return fitting.front();
    const auto strength = [&](std::size_t i) { return hints_[i].input - hints_[i].output; };
    if (fitting.size() > 1) {
      if (const auto one = only(strongest(fitting, strength), strength)) return *one;
    }
    if (fitting.empty()) {
      // Columns without a unit may be the input; those in another unit are none.
      std::copy_if(left.begin(), left.end(), std::back_inserter(fitting),
                   [&](std::size_t i) { return columns_[i].unit.empty() || unit.empty(); });
      if (fitting.size() == 1) return fitting.front();
      if (fitting.empty()) {
        if (left.size() == 1) return left.front();
        fail(fmt::format("no column is in {}, the unit of the model's input; columns: {}", unit, list()));
      }
      if (const auto one = only(strongest(fitting, strength), strength)) return *one;
    }
    fail(fmt::format("which column is the model's input{}? Columns: {}. For example: `{}`",
                     unit.empty() ? "" : " [" + unit + "]", list(),
                     command(fmt::format("--input {}", fitting.front() + 1))));
  }

  Table& table_;
  const std::vector<Column>& columns_;
  std::string path_;
  std::filesystem::path file_;
  const Options& options_;
  std::optional<std::size_t> replaced_time_;  ///< the column of times, also where a period replaces it
  std::vector<std::size_t> times_;            ///< of channels that have one each
  std::vector<Hints> hints_;
};

}  // namespace

Roles find_record(Table& table, const std::filesystem::path& path, const Options& options) {
  return Finder(table, path, options).record();
}

Roles find_input(Table& table, const std::filesystem::path& path, const Options& options, const std::string& unit) {
  return Finder(table, path, options).input(unit);
}

std::optional<double> epoch_unit_s(const Column& time) {
  // A counter of an uptime may reach the same size, but its rows would lie hours apart.
  constexpr double kFrom_s = 1e9;  // 2001
  constexpr double kTo_s = 4.1e9;  // 2099
  constexpr double kLongestStep_s = 600.0;
  if (time.is_clock || !time.unit.empty() || time.sample.size() < 2) return std::nullopt;
  const double step = (time.sample.back() - time.sample.front()) / static_cast<double>(time.sample.size() - 1);
  for (const double unit_s : {1.0, 1e-3, 1e-6, 1e-9}) {
    const double at_s = time.sample.front() * unit_s;
    if (at_s > kFrom_s && at_s < kTo_s && std::abs(step) * unit_s < kLongestStep_s) return unit_s;
  }
  return std::nullopt;
}

double time_unit_s(const Column& time, const std::filesystem::path& path, const Options& options) {
  if (time.is_clock) return 1.0;
  if (time.unit.empty()) return epoch_unit_s(time).value_or(1.0);
  if (const auto seconds = seconds_in(time.unit)) return *seconds;
  throw DataError(fmt::format(
      "{}: the time column \"{}\" is in {}, which is no unit of time; with the sample period in seconds: `{}`",
      path.string(), readable(time.label, kLongestShown), time.unit, command_with(options, path, "--period SECONDS")));
}

double output_time_unit_s(const std::vector<Column>& columns, const Roles& roles, const std::filesystem::path& path,
                          const Options& options) {
  const Column& own = columns[*roles.output_time];
  return time_unit_s(own.unit.empty() ? columns[*roles.time] : own, path, options);
}

}  // namespace eha::importer
