// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace eha::record {

/// Writes a text as one field of a CSV row: in quotes if it contains a quote, a separator or an end of line (RFC 4180).
[[nodiscard]] inline std::string csv_field(std::string_view text) {
  if (text.find_first_of("\",;\t\r\n") == std::string_view::npos) return std::string(text);
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + "\"";
}

/// Writes a name as a field. Puts an apostrophe before a name that a spreadsheet would read as a formula, because
/// formulas can start programs.
[[nodiscard]] inline std::string csv_name(std::string_view name) {
  const bool is_formula = name.find_first_of("=+-@\t\r") == 0;
  return csv_field(is_formula ? "'" + std::string(name) : std::string(name));
}

}  // namespace eha::record
