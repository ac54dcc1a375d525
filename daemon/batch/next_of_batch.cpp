// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/batch/next_of_batch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/free_name.hpp"
#include "core/reading_options.hpp"
#include "core/shell_word.hpp"
#include "daemon/batch/table_text.hpp"

namespace eha::batch {
namespace {

/// Whether a file is read by options, or a record's part or rows chosen; `eha compare` has no such options.
bool is_read_by_options(const std::vector<std::string>& options) {
  return std::any_of(options.begin(), options.end(),
                     [](const std::string& word) { return reading_option(word) != nullptr; });
}

/// " --intersample foh" as the records were fitted; empty where no option says it.
std::string intersample_of(const std::vector<std::string>& options) {
  constexpr std::string_view kName = "--intersample";
  for (std::size_t i = 0; i < options.size(); ++i) {
    if (options[i] == kName && i + 1 < options.size())
      return fmt::format(" {} {}", kName, shell_quoted(options[i + 1]));
    if (options[i].starts_with(fmt::format("{}=", kName))) return " " + shell_quoted(options[i]);
  }
  return {};
}

std::string compare(const BatchFolder& folder, const Table& table, const std::vector<std::size_t>& rows) {
  const std::vector<std::string>& options = folder.batch().rules.options;
  const bool by_models = is_read_by_options(options);
  std::string command = "eha compare";
  for (const std::size_t row : rows) {
    const Record& record = table.rows[row].record;
    const auto model = folder.path() / "records" / record.id / "models" / (table.common_model + ".json");
    command += " " + shell_word(by_models ? model.string() : record.source);
  }
  return by_models ? command : command + intersample_of(options);
}

/// The row whose parameters lie nearest to the medians, of the records with nothing apart; one with a warning only
/// where every one of them has. @param but  not this one
std::optional<std::size_t> ordinary_row(const Table& table, std::size_t but) {
  std::map<std::size_t, double> furthest;  // of each row, in distances from which on it would be apart
  const std::vector<NotCompared> left_out = not_compared(table.rows, table.common_model);
  const auto is_left_out = [&](std::size_t row) {
    return std::any_of(left_out.begin(), left_out.end(), [&](const NotCompared& one) { return one.row == row; });
  };
  for (const Parameter& one : parameters_of(table.rows, table.common_model)) {
    for (const Estimate& estimate : one.estimates) {
      const bool is_out =
          estimate.row == but || !table.rows[estimate.row].outliers.empty() || is_left_out(estimate.row);
      if (is_out || !(estimate.half_width > 0.0)) continue;
      double& of_row = furthest[estimate.row];
      of_row = std::max(of_row, std::abs(estimate.value - one.median) / estimate.half_width);
    }
  }
  const auto nearest = std::min_element(furthest.begin(), furthest.end(), [&](const auto& a, const auto& b) {
    return std::pair(!table.rows[a.first].warnings.empty(), a.second) <
           std::pair(!table.rows[b.first].warnings.empty(), b.second);
  });
  return nearest == furthest.end() ? std::nullopt : std::optional(nearest->first);
}

/// The rows that take part in the comparison.
std::vector<std::size_t> compared_rows(const Table& table) {
  std::vector<std::size_t> rows;
  for (const Parameter& one : parameters_of(table.rows, table.common_model)) {
    for (const Estimate& estimate : one.estimates) rows.push_back(estimate.row);
  }
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

/// A command that fits a record, with a folder for its models where it has none.
std::string with_folder(std::string command, const Record& record) {
  if (!command.starts_with("eha fit ") || command.find(" -o ") != std::string::npos) return command;
  const std::string stem = std::filesystem::path(record.source).stem().string();
  return command + " -o " + shell_word(free_name("models-" + stem));
}

/// The first `eha fit` or `eha import` of a record that a reason names between backticks; none without.
std::optional<std::string> command_in(const std::string& reason, const Record& record) {
  const std::string word = shell_word(record.source);
  for (std::size_t from = reason.find('`'); from != std::string::npos;) {
    const std::size_t end = reason.find('`', from + 1);
    if (end == std::string::npos) break;
    const std::string command = reason.substr(from + 1, end - from - 1);
    if (command.starts_with("eha fit " + word) || command.starts_with("eha import " + word)) return command;
    from = reason.find('`', end + 1);
  }
  return std::nullopt;
}

std::string fit_of(const BatchFolder& folder, const Record& record) {
  std::string command = "eha fit " + shell_word(record.source);
  for (const std::string& word : folder.batch().rules.options) command += " " + shell_quoted(word);
  return command;
}

}  // namespace

std::string next_command(const BatchFolder& folder, const Table& table) {
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    if (table.rows[i].outliers.empty()) continue;
    if (const auto ordinary = ordinary_row(table, i)) return compare(folder, table, {*ordinary, i});
  }
  const std::vector<std::size_t> rows = compared_rows(table);
  if (!table.trends.empty() && rows.size() > 1) return compare(folder, table, {rows.front(), rows.back()});
  for (const Row& row : table.rows) {
    if (row.judged) continue;
    if (const auto command = command_in(row.reason, row.record)) return with_folder(*command, row.record);
  }
  const std::vector<NotCompared> left_out = not_compared(table.rows, table.common_model);
  if (!left_out.empty()) {
    const std::size_t row = left_out.front().row;
    const auto ordinary = left_out.front().in_part ? ordinary_row(table, row) : std::nullopt;
    if (ordinary) return compare(folder, table, {*ordinary, row});
    const Record& record = table.rows[row].record;
    return with_folder(fit_of(folder, record), record);
  }
  if (rows.size() > 1 && rows.size() < kFewestForOutliers) return compare(folder, table, rows);
  return "xdg-open " + shell_word((folder.path() / "report.html").string());
}

}  // namespace eha::batch
