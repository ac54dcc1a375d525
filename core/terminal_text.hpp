// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace eha {

/// Makes text safe for a terminal: names, units and reasons of files are untrusted. Characters that control the
/// terminal (ECMA-48: U+0000 to U+001F but newline and tab, U+007F to U+009F) become '?', as do the bidirectional
/// controls (U+202A to U+202E and U+2066 to U+2069), which can make a command read as another one. Other bytes are
/// kept.
[[nodiscard]] inline std::string terminal_text(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : '\0');
    const auto third = static_cast<unsigned char>(i + 2 < text.size() ? text[i + 2] : '\0');
    const bool turns = byte == 0xE2 && ((next == 0x80 && third >= 0xAA && third <= 0xAE) ||
                                        (next == 0x81 && third >= 0xA6 && third <= 0xA9));
    if (turns || (byte == 0xC2 && next >= 0x80 && next < 0xA0)) {
      result += '?';
      i += turns ? 2 : 1;
    } else {
      const bool controls = (byte < ' ' && byte != '\n' && byte != '\t') || byte == 0x7f;
      result += controls ? '?' : text[i];
    }
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
