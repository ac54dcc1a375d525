// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace eha::record {

/// A text as one field of a CSV row: in quotes where it has a quote, a separator or an end of line (RFC 4180).
[[nodiscard]] inline std::string csv_field(std::string_view text) {
  if (text.find_first_of("\",;\t\r\n") == std::string_view::npos) return std::string(text);
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + "\"";
}

/// A name as a field. One that a spreadsheet would take for a formula, which can start programs there, gets an
/// apostrophe.
[[nodiscard]] inline std::string csv_name(std::string_view name) {
  const bool is_formula = name.find_first_of("=+-@\t\r") == 0;
  return csv_field(is_formula ? "'" + std::string(name) : std::string(name));
}

}  // namespace eha::record
