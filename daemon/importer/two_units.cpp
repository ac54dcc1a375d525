// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/two_units.hpp"

#include <fmt/format.h>

#include <optional>

#include "core/display_unit.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/column_text.hpp"
#include "daemon/importer/roles.hpp"

namespace eha::importer {
namespace {

/// The factor between two units of one kind; none of two kinds.
std::optional<double> factor_between(const std::string& from, const std::string& to) {
  const std::optional<double> from_s = seconds_in(from);
  const std::optional<double> to_s = seconds_in(to);
  return from_s && to_s ? std::optional(*from_s / *to_s) : unit_factor(from, to);
}

}  // namespace

std::string name_without_unit(std::string name, const std::string& unit) {
  if (unit.empty()) return name;
  const auto [before, own] = name_and_unit(name);
  if (own == unit && !before.empty() && before != name) return before;
  const std::size_t blank = name.rfind(' ');
  if (blank != std::string::npos && blank > 0 && unit_of(name.substr(blank + 1)) == unit) name.erase(blank);
  return name;
}

std::vector<std::string> remarks_on_two_units(const std::vector<Column>& columns, const std::vector<std::size_t>& read,
                                              const std::filesystem::path& path) {
  std::vector<std::string> remarks;
  for (const std::size_t i : read) {
    const Column& column = columns[i];
    if (column.other_unit.empty()) continue;
    const std::optional<double> factor = factor_between(column.unit, column.other_unit);
    remarks.push_back(fmt::format(
        "{}: column {} has two units, {} in its name and {} below it: {} is taken; if {} is right, {}: "
        "give it with --input-unit or --output-unit, or correct the name in a copy of the file",
        path.string(), described(columns, i), column.unit, column.other_unit, column.unit, column.other_unit,
        factor ? fmt::format("its values are wrong by the factor {:.6g}", *factor) : "it is another quantity"));
  }
  return remarks;
}

}  // namespace eha::importer
