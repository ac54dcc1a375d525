// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/split_clock.hpp"

#include <cmath>
#include <string_view>

#include "daemon/importer/clock_text.hpp"
#include "daemon/importer/csv_fields.hpp"

namespace eha::importer {

std::vector<double> sample_of_split_clock(const std::vector<std::string>& lines, const Dialect& dialect,
                                          const std::vector<Column>& columns, std::size_t most) {
  constexpr std::size_t kMilliseconds = 3;
  if (dialect.delimiter != ',' || columns.size() < 3 || !columns[0].is_clock || columns[0].is_number) return {};
  const bool is_whole = std::abs(clock_quantum_s(columns[0].sampled_text) - 1.0) < 1e-9;
  if (!is_whole || !columns[0].label.empty()) return {};
  CsvFields fields(dialect.delimiter);
  ClockReader reader;
  std::vector<double> sample;
  for (std::size_t i = dialect.first_data_line - 1; i < lines.size() && sample.size() < most; ++i) {
    if (is_comment(lines[i]) || !fields.split(lines[i]) || fields.size() < columns.size()) continue;
    const std::string_view part = fields[1];
    const auto time_s = reader.seconds(std::string(fields[0]) + "," + std::string(part));
    const bool is_part = part.size() == kMilliseconds && part.find_first_not_of("0123456789") == std::string_view::npos;
    if (!is_part || !time_s) return {};
    sample.push_back(*time_s);
  }
  return sample;
}

}  // namespace eha::importer
