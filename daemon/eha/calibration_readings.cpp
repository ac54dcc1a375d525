// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/calibration_readings.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cstddef>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>

#include "core/error.hpp"
#include "daemon/eha/length_argument.hpp"
#include "daemon/importer/imported_table.hpp"

namespace eha::cli {

CalibrationPoint point_of(const std::string& text, const DisplayUnit& unit) {
  const std::size_t equals = text.find('=');
  const auto position_in = inches_of(with_decimal_point(std::string_view(text).substr(0, equals)), unit);
  const std::string point = equals == std::string::npos ? std::string() : with_decimal_point(text.substr(equals + 1));
  std::string_view volts = point;
  if (volts.ends_with('V')) volts.remove_suffix(1);
  double voltage_V = 0.0;
  const auto [end, error] = std::from_chars(volts.data(), volts.data() + volts.size(), voltage_V);
  if (!position_in || error != std::errc() || end != volts.data() + volts.size()) {
    throw UsageError(
        fmt::format("--at {}: expected a position, = and volts, such as 75mm=4.921 or 2.95in=4.917", text));
  }
  return {*position_in, voltage_V};
}

std::vector<CalibrationPoint> points_of_file(const std::string& path) {
  const std::unique_ptr<importer::Table> table = importer::open_table(path, {});
  std::optional<std::size_t> position;
  std::optional<std::size_t> voltage;
  const std::vector<importer::Column>& columns = table->columns();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (is_length(columns[i].unit)) position = i;
    if (columns[i].unit == "V") voltage = i;
  }
  if (!position || !voltage) {
    throw DataError(
        fmt::format("{}: expected the columns position_mm (or position_in) and voltage_V; write position_mm;voltage_V "
                    "as first line",
                    path));
  }
  importer::Selection selection;
  selection.columns = {*position, *voltage};
  const importer::Rows rows = table->read(selection, {});
  const double factor = inches_of("1" + columns[*position].unit).value_or(1.0);
  std::vector<CalibrationPoint> points;
  for (std::size_t i = 0; i < rows.count(); ++i) points.push_back({factor * rows.columns[0][i], rows.columns[1][i]});
  return points;
}

std::string typed_unit(const std::vector<std::string>& pairs) {
  std::string unit;
  for (const std::string& pair : pairs) {
    const std::string of_pair = unit_of_length(std::string_view(pair).substr(0, pair.find('=')));
    if (of_pair.empty() || (!unit.empty() && of_pair != unit)) return {};
    unit = of_pair;
  }
  return unit;
}

}  // namespace eha::cli
