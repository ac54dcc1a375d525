// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/plot/key.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace eha::plot {
namespace {

constexpr double kKeySample_px = 70.0;  // the line beside an entry, and air
constexpr double kLetter_px = 8.5;

std::vector<std::string> entries_of(const Panel& panel) {
  std::vector<std::string> entries;
  const auto add = [&](const std::string& label) {
    if (!label.empty()) entries.push_back(label);
  };
  for (const Series& series : panel.series) add(series.label);
  for (const Rule& rule : panel.rules) add(rule.label);
  for (const Shade& shade : panel.shades) add(shade.label);
  return entries;
}

}  // namespace

double letters_of(std::string_view text) {
  constexpr double kWide = 1.3;
  constexpr double kWidest = 1.6;
  double letters = 0.0;
  for (const char c : text) {
    const bool is_continued = (static_cast<unsigned char>(c) & 0xC0U) == 0x80;  // of a UTF-8 character
    if (c == 'm' || c == 'w') {
      letters += kWidest;
      continue;
    }
    if (!is_continued) letters += (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') ? kWide : 1.0;
  }
  return letters;
}

std::size_t key_lines(const Panel& panel) {
  const std::vector<std::string> entries = entries_of(panel);
  double longest = 0.0;
  for (const std::string& entry : entries) longest = std::max(longest, letters_of(entry));
  const double entry_px = kKeySample_px + kLetter_px * longest;
  const std::size_t columns = std::max<std::size_t>(1, static_cast<std::size_t>(kKeyWidth_px / entry_px));
  return (entries.size() + columns - 1) / columns;
}

std::string key_width(const Panel& panel) {
  constexpr double kNeeded = 0.8;  // of that, for a letter of the lower case
  constexpr double kAir = 1.0;     // letters before the line of the next entry
  double reserved = 0.0;
  double needed = 0.0;
  for (const std::string& entry : entries_of(panel)) {
    reserved = std::max(reserved, static_cast<double>(entry.size()));
    needed = std::max(needed, kNeeded * letters_of(entry));
  }
  return fmt::format("set key width {:.1f}\n", needed - reserved + kAir);
}

}  // namespace eha::plot
