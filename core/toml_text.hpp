// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace eha {

/// Writes a text as a TOML string on one line. No text can end the string.
[[nodiscard]] inline std::string toml_string(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      result += '\\';
      result += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      result += std::string("\\u00") + kDigits[byte >> 4U] + kDigits[byte & 0xFU];
    } else {
      result += c;
    }
  }
  return result + "\"";
}

/// Writes a text as part of a comment: control characters become '?', so that no line of it begins a key.
[[nodiscard]] inline std::string toml_comment(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (const auto byte = static_cast<unsigned char>(c); byte < 0x20 || byte == 0x7f) c = '?';
  }
  return result;
}

}  // namespace eha
