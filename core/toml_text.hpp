// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace eha {

/// A text as a TOML string on one line. No text ends it: what is in quotes in a generated file stays a value.
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

/// A text as part of a comment: no end of a line in it begins a key.
[[nodiscard]] inline std::string toml_comment(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (const auto byte = static_cast<unsigned char>(c); byte < 0x20 || byte == 0x7f) c = '?';
  }
  return result;
}

}  // namespace eha
