// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/written_on_change.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <set>

namespace eha::importer {
namespace {

constexpr std::size_t kFewestChanges = 5;
constexpr double kMostRepeated = 0.05;   // of the values: a column that lost cells repeats a held command more often
constexpr std::size_t kTimesALevel = 3;  // on average: a sine that lost cells has no level twice

}  // namespace

std::optional<std::string> hold_written_on_change(std::vector<double>& command) {
  std::size_t values = 0;
  std::size_t repeated = 0;
  std::set<double> levels;
  double last = std::nan("");
  for (const double value : command) {
    if (!std::isfinite(value)) continue;
    ++values;
    levels.insert(value);
    if (value == last) ++repeated;
    last = value;
  }
  if (values < kFewestChanges || 2 * values >= command.size() || kTimesALevel * levels.size() > values ||
      static_cast<double>(repeated) > kMostRepeated * static_cast<double>(values)) {
    return std::nullopt;
  }
  last = std::nan("");
  for (double& value : command) {
    if (std::isfinite(value)) last = value;
    value = last;
  }
  return fmt::format(
      "the input stands in {} of {} rows only, each time another value: it is taken as written where it "
      "changes, and held in the rows between",
      values, command.size());
}

}  // namespace eha::importer
