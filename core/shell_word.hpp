// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include "core/terminal_text.hpp"

namespace eha {

/// Quotes a word for a shell if necessary. For every untrusted name in a command that the user may copy.
[[nodiscard]] inline std::string shell_word(std::string_view word) {
  static constexpr std::string_view kSpecial = " '\"\\$`*?[]{}()<>|&;#~!^\x7f";
  // Control characters too: shown as '?' they would become a pattern.
  const auto is_special = [](char c) { return (c >= '\0' && c < ' ') || kSpecial.find(c) != std::string_view::npos; };
  const bool plain = !word.empty() && std::none_of(word.begin(), word.end(), is_special) && terminal_text(word) == word;
  if (plain) return std::string(word);
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace eha
