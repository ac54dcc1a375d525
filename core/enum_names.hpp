// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>

namespace eha {

/// The names of an enum's values as files and messages spell them: one table for both directions.
template <class Enum, std::size_t count>
using EnumNames = std::array<std::pair<std::string_view, Enum>, count>;

/// "unknown" for a value without a name. Real-time safe.
template <class Enum, std::size_t count>
[[nodiscard]] constexpr std::string_view name_in(const EnumNames<Enum, count>& names, Enum value) noexcept {
  for (const auto& [name, named] : names) {
    if (named == value) return name;
  }
  return "unknown";
}

template <class Enum, std::size_t count>
[[nodiscard]] constexpr std::optional<Enum> value_in(const EnumNames<Enum, count>& names,
                                                     std::string_view name) noexcept {
  for (const auto& [known, value] : names) {
    if (known == name) return value;
  }
  return std::nullopt;
}

}  // namespace eha
