// SPDX-License-Identifier: GPL-3.0-or-later
// Names, units and reasons as a stranger could write them into a file.
#pragma once

#include <array>
#include <cstddef>
#include <random>
#include <string>
#include <string_view>

namespace eha::test {

/// What ends or begins comments, strings, escapes, directives and lines in C, Python, Octave, MATLAB, gnuplot and a
/// shell, markup, and what controls a terminal.
inline constexpr auto kHostilePieces = std::to_array<std::string_view>({
    // clang-format off
    "*/", "*\\", "/*", "\\", "\\\n", "\n", "\r", "\r\n", "\v", "\f", "\"", "\"\"\"", "'", "''\'", "?\?/", "?\?/\n",
    "*?\?/", "%{", "%}", "%{\n", "...\n", "#", "#{", "# coding: utf-7\n", "@include", "-*- texinfo -*-", "$(id)",
    "`id`", "\xe2\x80\xa8", "\xc2\x85", "\xff", "\xc0\xaf", "\x1a", "\x1b[", "{", "}", "{}", "{0}", "%n", "%s",
    "<!--", "]]>", "&lt;", "NAME_", "FUNCTION_", "DRIVING", "COUNT", "int pwned;", "int pwned(void) { return 1; }",
    "#define double int\n", "pwned = 1\n", "import os\n", "\nend\nsystem('id')\n", "/", "*", "V", "in/s", "u_", " ",
    "_Pragma(\"once\")", "\\u002a\\u002f", "+ACoALw-", "\b", "//\\\n", "<script>alert(1)</script>", "</title>",
    "</style>", "</text>", "</svg>", "-->", "<![CDATA[", "<?xml", "\" onload=\"x", "' onload='x", "&#x3c;", "&amp",
    "\nEOD\n", "\ne\n", "\nsystem('id >&2')\n", "'; set output 'x", "\n!id\n", "@id", "\nNext: eha arm\n", "\x1b[2J",
    "\x1b]0;x\a",
    "\xe2\x80\xae", "\xe2\x80\x8f", "\x9b""31m", "\nehad: error: x\n", "<3>"  // clang-format on
});

/// A text of 1 to 8 of these pieces, some behind so many blanks that a text of `longest` is cut off within them.
inline std::string hostile(std::mt19937_64& generator, std::size_t longest) {
  std::string text;
  const std::size_t pieces = 1 + generator() % 8;
  for (std::size_t i = 0; i < pieces; ++i) {
    text += generator() % 8 == 0 ? std::string(1, static_cast<char>(generator() % 256))
                                 : std::string(kHostilePieces[generator() % kHostilePieces.size()]);
  }
  // The end of a comment also where the text is cut off.
  if (generator() % 4 == 0) text = std::string(longest > text.size() ? longest - text.size() / 2 : 1, ' ') + text;
  return text;
}

}  // namespace eha::test
