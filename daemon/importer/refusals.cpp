// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/refusals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "core/shell_word.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/column_text.hpp"
#include "daemon/importer/time_grid.hpp"

namespace eha::importer {
namespace {

/// The number of rows between two values of a column that has one in every nth row only; none where it has more, or not
/// evenly.
std::optional<std::size_t> every_nth(const std::vector<double>& sample) {
  constexpr std::size_t kFewest = 5;
  std::vector<std::size_t> measured;
  for (std::size_t k = 0; k < sample.size(); ++k) {
    if (std::isfinite(sample[k])) measured.push_back(k);
  }
  if (measured.size() < kFewest) return std::nullopt;
  const std::size_t every = measured[1] - measured[0];
  for (std::size_t i = 1; i < measured.size(); ++i) {
    if (measured[i] - measured[i - 1] != every) return std::nullopt;
  }
  return every > 1 ? std::optional(every) : std::nullopt;
}

}  // namespace

void refuse_time_without_unit(const Rows& rows, const Column& time, const std::filesystem::path& path,
                              const Options& options) {
  constexpr std::size_t kFewRows = 50;  // typed by hand
  constexpr double kLongestStep_s = 0.5;
  const std::vector<double>& times = rows.columns.front();
  if (time.is_clock || !time.unit.empty() || times.size() < kFewRows || epoch_unit_s(time)) return;
  std::vector<double> steps(times.size() - 1);
  for (std::size_t k = 0; k < steps.size(); ++k) steps[k] = times[k + 1] - times[k];
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  if (!(*middle > kLongestStep_s)) return;
  RowClock clock;
  for (const double at : times) clock.add(at, std::pow(10.0, -rows.time_decimals));
  const std::optional<RowPeriod> period = clock.period();
  if (!period) return;
  Options even = options;
  if (options.time && options.resample) {
    // A time that was named would be asked for again.
    even.command = command_with(options, path, "--resample");
    even.command.erase(even.command.rfind(" --resample"), std::string_view(" --resample").size());
  }
  std::string readings;
  for (const auto& [unit, unit_s] : {std::pair("seconds", 1.0), {"milliseconds", 1e-3}, {"microseconds", 1e-6}}) {
    if (*middle * unit_s < kShortestStep_s) continue;
    readings += fmt::format("; if in {}: `{}`", unit, command_with(even, path, period_options(*period, unit_s)));
  }
  throw DataError(fmt::format("{}: the clock{} rises by {:.6g} a row and has no unit{}", path.string(),
                              time.label.empty() ? "" : fmt::format(" \"{}\"", readable(time.label, kLongestShown)),
                              *middle, readings));
}

void refuse_slower_output(const Table& table, const Roles& roles, const std::filesystem::path& path,
                          const Options& options) {
  const auto form = table.text_form();
  const auto every = every_nth(table.columns()[*roles.output].sample);
  if (options.resample || !form || form->delimiter == ' ' || !every) return;
  throw DataError(
      fmt::format("{}: column {} has a value in every {}{} row only, as of a slower sensor; `{}` holds the models "
                  "against those rows, by the input of all",
                  path.string(), described(table.columns(), *roles.output), *every,
                  *every == 2   ? "nd"
                  : *every == 3 ? "rd"
                                : "th",
                  command_with(options, path, "--resample")));
}

void refuse_exchanged(const ident::Record& record, const Roles& roles, const std::filesystem::path& path,
                      const Options& options) {
  const DisplayUnit inches("in");
  if (options.input || options.output || record.output_channel.unit != "V") return;
  if (inches.of(record.input_channel.unit) != "in") return;
  throw DataError(fmt::format(
      "{}: the second column, the input, is a length, and the third, the output, a voltage; if they are exchanged: "
      "`{}`; if not, name them: `{}`",
      path.string(),
      command_with(options, path, fmt::format("--input {} --output {}", *roles.output + 1, roles.input + 1)),
      command_with(options, path, fmt::format("--input {} --output {}", roles.input + 1, *roles.output + 1))));
}

}  // namespace eha::importer
