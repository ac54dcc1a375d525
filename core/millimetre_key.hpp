// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace eha {

inline constexpr double kMillimetresPerInch = 25.4;

/// The key of a quantity with millimetres in place of inches.
struct MillimetreKey {
  std::string name;     ///< "travel_min_mm", "gain_V_per_mm"
  double factor = 1.0;  ///< converts the value to that of the key in inches
};

/// Returns the key for a key with inches among its words, such as "travel_min_in" or "scale_in_per_V"; none for others.
[[nodiscard]] inline std::optional<MillimetreKey> millimetre_key(std::string_view key) {
  for (std::size_t at = key.find("in"); at != std::string_view::npos; at = key.find("in", at + 1)) {
    const bool begins = at > 0 && key[at - 1] == '_';
    const bool ends = at + 2 == key.size() || key[at + 2] == '_';
    if (!begins || !ends) continue;
    const bool is_divisor = key.substr(0, at).ends_with("_per_");
    return MillimetreKey{std::string(key.substr(0, at)) + "mm" + std::string(key.substr(at + 2)),
                         is_divisor ? kMillimetresPerInch : 1.0 / kMillimetresPerInch};
  }
  return std::nullopt;
}

}  // namespace eha
