// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include "core/terminal_text.hpp"

namespace eha {

/// Quotes a word for a shell if necessary: an option, a value, a whole command line.
[[nodiscard]] inline std::string shell_quoted(std::string_view word) {
  static constexpr std::string_view kSpecial = " \t\n'\"\\$`*?[]{}()<>|&;#~!^";
  // What a terminal would show as '?', too: copied, it would be a pattern.
  const bool plain =
      !word.empty() && word.find_first_of(kSpecial) == std::string_view::npos && terminal_text(word) == word;
  if (plain) return std::string(word);
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// The name of a file as a word of a command, quoted if necessary; one that begins with '-' is no option of it. For
/// every untrusted name in a command that the user may copy.
[[nodiscard]] inline std::string shell_word(std::string_view name) {
  return name.starts_with('-') ? shell_quoted("./" + std::string(name)) : shell_quoted(name);
}

/// A command without line breaks, with which a name in it could imitate another one on a page.
[[nodiscard]] inline std::string on_one_line(std::string command) {
  std::replace_if(
      command.begin(), command.end(), [](char c) { return c == '\n' || c == '\r'; }, '?');
  return command;
}

}  // namespace eha
