// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace eha {

/// Quotes a word for a shell if necessary. For every untrusted name in a command that the user may copy.
[[nodiscard]] inline std::string shell_word(std::string_view word) {
  const bool plain = !word.empty() && word.find_first_of(" \t\r\n'\"\\$`*?[]{}()<>|&;#~!^") == std::string_view::npos;
  if (plain) return std::string(word);
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace eha
