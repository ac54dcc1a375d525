// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

#include "core/utf8.hpp"

namespace eha {

/// Whether a UTF-8 character controls a terminal (ECMA-48: U+0000 to U+001F but newline and tab, U+007F to U+009F) or
/// the direction of writing (U+061C, U+200E, U+200F, U+202A to U+202E, U+2066 to U+2069), which can make a command read
/// as another one. Alone, the byte of a C1 control is one too, on a terminal that is not set to UTF-8.
[[nodiscard]] inline bool controls_text(std::string_view character) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(character[i]); };
  switch (character.size()) {
    case 1:
      return (byte(0) < ' ' && character != "\n" && character != "\t") || (byte(0) >= 0x7f && byte(0) < 0xA0);
    case 2:
      return (byte(0) == 0xC2 && byte(1) < 0xA0) || character == "\xD8\x9C";
    case 3:
      return (byte(0) == 0xE2 && byte(1) == 0x80 && (byte(2) == 0x8E || byte(2) == 0x8F)) ||
             (byte(0) == 0xE2 && byte(1) == 0x80 && byte(2) >= 0xAA && byte(2) <= 0xAE) ||
             (byte(0) == 0xE2 && byte(1) == 0x81 && byte(2) >= 0xA6 && byte(2) <= 0xA9);
    default:
      return false;
  }
}

/// Makes text safe for a terminal: names, units and reasons of files are untrusted. What controls_text() becomes '?'.
/// Other bytes are kept.
[[nodiscard]] inline std::string terminal_text(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = std::max<std::size_t>(character_length(text, i), 1);
    const std::string_view character = text.substr(i, length);
    if (controls_text(character)) {
      result += '?';
    } else {
      result += character;
    }
    i += length;
  }
  return result;
}

/// Makes a name of a file fit for one line of a message: as terminal_text(), and what ends a line (U+000A, U+2028,
/// U+2029) or leaps ahead in it (U+0009) becomes '?' too. What stands behind the end of a line could be taken for a
/// message of the program.
[[nodiscard]] inline std::string one_line(std::string_view name) {
  std::string result = terminal_text(name);
  for (const std::string_view end : {"\n", "\t", "\xE2\x80\xA8", "\xE2\x80\xA9"}) {
    for (std::size_t at = result.find(end); at != std::string::npos; at = result.find(end, at)) {
      result.replace(at, end.size(), "?");
    }
  }
  return result;
}

}  // namespace eha
