// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/wrapped_text.hpp"

#include <algorithm>

namespace eha::cli {

namespace {

/// The first word of a text that stays in one piece: a command, or a step that eha offers.
std::string_view first_piece(std::string_view rest) {
  // A line that begins so is a step; within a text it may be a stranger's.
  constexpr std::string_view kStep = "Next:";
  std::size_t end = std::min(rest.find(' '), rest.size());
  for (std::size_t next = rest.find_first_not_of(' ', end); next < rest.size() && rest.substr(next).starts_with(kStep);
       next = rest.find_first_not_of(' ', end)) {
    end = std::min(rest.find(' ', next), rest.size());
  }
  // A command is copied in one piece.
  if (const std::size_t command = rest.find("`eha "); command < end) {
    const std::size_t close = rest.find('`', command + 1);
    if (close != std::string_view::npos) end = std::min(rest.find(' ', close), rest.size());
  }
  return rest.substr(0, end);
}

/// Takes the first line off a text.
std::string_view take_line(std::string_view& rest) {
  const std::size_t end = std::min(rest.find('\n'), rest.size());
  const std::string_view line = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return line;
}

/// Whether a line goes on with the sentence of the one before, at the same column: its first word found no room there.
bool goes_on(std::string_view before, std::string_view line, std::size_t begin) {
  if (line.size() <= begin || line.find_first_not_of(' ') != begin) return false;
  return before.size() + 1 + first_piece(line.substr(begin)).size() > kPrintedWidth;
}

}  // namespace

std::string wrapped(const std::string& text, std::size_t indent) {
  std::string result;
  std::size_t column = indent;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::string_view word = first_piece(rest);
    rest.remove_prefix(std::min(word.size() + 1, rest.size()));
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
  const bool ends_in_line = completed.ends_with('\n');
  while (!rest.empty()) {
    const std::string_view line = take_line(rest);
    std::string_view before = take_line(text);
    if (line.size() <= kPrintedWidth || line == before) {
      result.append(line).append("\n");
      continue;
    }
    // "because         The plant ...": text goes on below where it begins.
    const std::size_t gap = line.find("  ");
    const bool is_indented = line.starts_with(' ') || (gap != std::string_view::npos && gap < kLabelWidth);
    const std::size_t begin =
        is_indented
            ? std::min<std::size_t>(line.find_first_not_of(' ', gap == std::string_view::npos ? 0 : gap), kLabelWidth)
            : 0;
    std::string paragraph(line.substr(begin));
    // The rest of its sentences moves up into what is left of the line.
    for (std::string_view next = text; begin > 0 && !rest.empty();) {
      const std::string_view next_before = take_line(next);
      if (!goes_on(before, next_before, begin)) break;
      paragraph.append(" ").append(take_line(rest).substr(begin));
      before = next_before;
      text = next;
    }
    result.append(line.substr(0, begin)).append(wrapped(paragraph, begin)).append("\n");
  }
  if (!ends_in_line && result.ends_with('\n')) result.pop_back();
  return result;
}

}  // namespace eha::cli
