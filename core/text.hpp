// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace eha {

/// Bytes of a line of a table of numbers: a file of zeros, or a device, has no end of a line.
inline constexpr std::size_t kLongestTableLine = std::size_t{1} << 20;

/// Text for a message: control characters and bytes beyond ASCII become '?', and text beyond `length` becomes "...".
[[nodiscard]] inline std::string shortened(std::string_view text, std::size_t length) {
  std::string result(text.substr(0, length));
  for (char& c : result) {
    if (c < ' ' || c > '~') c = '?';
  }
  if (text.size() > length) result += "...";
  return result;
}

/// Number of single-character insertions, deletions and substitutions, and of neighbours that are exchanged, between
/// two texts (optimal string alignment). Cost O(|a| |b|).
[[nodiscard]] inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  std::vector<std::size_t> above(row);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::vector<std::size_t> last = row;
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t substituted = last[j] + (a[i] == b[j] ? 0 : 1);
      row[j + 1] = std::min({row[j] + 1, last[j + 1] + 1, substituted});
      const bool are_exchanged = i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j];
      if (are_exchanged) row[j + 1] = std::min(row[j + 1], above[j - 1] + 1);
    }
    above = last;
  }
  return row[b.size()];
}

/// The known key that a misspelt one is similar to: half of the letters right, or a forgotten unit. None if none is.
[[nodiscard]] inline std::optional<std::string_view> similar(std::string_view misspelt,
                                                             const std::vector<std::string_view>& known) {
  // A longer key is no misspelling, and the cost of comparing it grows with its length.
  constexpr std::size_t kLongestKey = 80;
  if (known.empty() || misspelt.size() > kLongestKey) return std::nullopt;
  const auto distance = [&](std::string_view key) { return edit_distance(misspelt, key); };
  const std::string_view nearest = *std::min_element(
      known.begin(), known.end(), [&](auto left, auto right) { return distance(left) < distance(right); });
  const bool lacks_unit = nearest.size() > misspelt.size() && nearest.substr(0, misspelt.size()) == misspelt;
  const bool is_similar = lacks_unit || distance(nearest) <= std::max(misspelt.size(), nearest.size()) / 2;
  return is_similar ? std::optional(nearest) : std::nullopt;
}

/// Continues "expected a known key" for a misspelt one: ` (did you mean "duration_s"?)`, or the list of all keys if
/// none is similar.
[[nodiscard]] inline std::string suggestion(std::string_view misspelt, const std::vector<std::string_view>& known) {
  if (known.empty()) return {};
  if (const auto nearest = similar(misspelt, known)) return " (did you mean \"" + std::string(*nearest) + "\"?)";
  std::string list;
  for (const std::string_view key : known) list += (list.empty() ? "" : ", ") + std::string(key);
  return " (one of " + list + ")";
}

}  // namespace eha
