// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/wrapped_text.hpp"

#include <algorithm>

namespace eha::cli {

std::string wrapped(const std::string& text, std::size_t indent) {
  // A line that begins so is a step that eha offers; within a text it may be a stranger's.
  constexpr std::string_view kStep = "Next:";
  std::string result;
  std::size_t column = indent;
  std::string_view rest = text;
  while (!rest.empty()) {
    std::size_t end = std::min(rest.find(' '), rest.size());
    for (std::size_t next = rest.find_first_not_of(' ', end);
         next < rest.size() && rest.substr(next).starts_with(kStep); next = rest.find_first_not_of(' ', end)) {
      end = std::min(rest.find(' ', next), rest.size());
    }
    // A command is copied in one piece.
    if (const std::size_t command = rest.find("`eha "); command < end) {
      const std::size_t close = rest.find('`', command + 1);
      if (close != std::string_view::npos) end = std::min(rest.find(' ', close), rest.size());
    }
    const std::string_view word = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (column > indent && column + 1 + word.size() > kPrintedWidth) {
      result += "\n" + std::string(indent, ' ');
      column = indent;
    } else if (column > indent) {
      result += ' ';
      ++column;
    }
    result += word;
    column += word.size();
  }
  return result;
}

std::string wrapped_where_longer(std::string_view text, const std::string& completed) {
  std::string result;
  std::string_view rest = completed;
  while (true) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = rest.substr(0, end);
    const std::size_t before = std::min(text.find('\n'), text.size());
    if (line.size() <= kPrintedWidth || line == text.substr(0, before)) {
      result += line;
    } else {
      // "because         The plant ...": text goes on below where it begins.
      const std::size_t gap = line.find("  ");
      const bool is_indented = line.starts_with(' ') || (gap != std::string_view::npos && gap < kLabelWidth);
      const std::size_t begin =
          is_indented
              ? std::min<std::size_t>(line.find_first_not_of(' ', gap == std::string_view::npos ? 0 : gap), kLabelWidth)
              : 0;
      result.append(line.substr(0, begin)).append(wrapped(std::string(line.substr(begin)), begin));
    }
    if (end == rest.size()) return result;
    result += '\n';
    rest.remove_prefix(end + 1);
    text.remove_prefix(std::min(before + 1, text.size()));
  }
}

}  // namespace eha::cli
