// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/inch.hpp"

namespace eha {

/// A unit of length.
struct LengthUnit {
  std::string_view name;
  double metres;
};

/// The units of length for displayed results.
inline constexpr std::array kLengthUnits =
    std::to_array<LengthUnit>({{"um", 1e-6}, {"mm", 1e-3}, {"cm", 1e-2}, {"m", 1.0}, {"in", kMetrePerInch}});

/// Whether `unit` is one of kLengthUnits; "in/s" is not.
[[nodiscard]] inline bool is_length(std::string_view unit) {
  return std::any_of(kLengthUnits.begin(), kLengthUnits.end(), [&](const LengthUnit& l) { return l.name == unit; });
}

/// The unit of length for displayed values; files for programs and --json keep the record's.
class DisplayUnit {
 public:
  DisplayUnit() = default;
  /// @param name  of kLengthUnits; empty: as the record
  explicit DisplayUnit(std::string name) : name_(std::move(name)) {}

  /// Whether every value is displayed in its own unit.
  [[nodiscard]] bool is_of_record() const noexcept { return name_.empty(); }

  /// Returns the display unit of values in `unit`: with the chosen length if `unit` is a length or a length per
  /// something, else `unit`.
  [[nodiscard]] std::string of(const std::string& unit) const {
    const std::string_view length = length_of(unit);
    return metres_in(length) && metres_in(name_) ? name_ + unit.substr(length.size()) : unit;
  }
  /// Returns the factor from `unit` to its display unit.
  [[nodiscard]] double factor(std::string_view unit) const {
    const auto from = metres_in(length_of(unit));
    const auto to = metres_in(name_);
    return from && to ? *from / *to : 1.0;
  }

 private:
  /// A length, or the length of a length per something: "in" of "in/(V s)".
  static std::string_view length_of(std::string_view unit) { return unit.substr(0, unit.find('/')); }
  static std::optional<double> metres_in(std::string_view unit) {
    for (const LengthUnit& length : kLengthUnits) {
      if (length.name == unit) return length.metres;
    }
    return std::nullopt;
  }

  std::string name_ = {};  ///< empty: as the record
};

/// Units of voltage and of current: name, kind, size in V or A.
struct ElectricUnit {
  std::string_view name;
  char kind;
  double size;
};
inline constexpr std::array kElectricUnits = std::to_array<ElectricUnit>(
    {{"V", 'V', 1.0}, {"mV", 'V', 1e-3}, {"kV", 'V', 1e3}, {"A", 'A', 1.0}, {"mA", 'A', 1e-3}});

/// The number of units `to` in one unit `from`, both lengths, voltages or currents, or the same; none for others.
[[nodiscard]] inline std::optional<double> unit_factor(const std::string& from, const std::string& to) {
  if (from == to) return 1.0;
  if (is_length(from) && is_length(to)) return DisplayUnit(to).factor(from);
  const auto electric = [](std::string_view name) {
    return std::find_if(kElectricUnits.begin(), kElectricUnits.end(),
                        [&](const auto& unit) { return unit.name == name; });
  };
  const auto a = electric(from);
  const auto b = electric(to);
  if (a == kElectricUnits.end() || b == kElectricUnits.end() || a->kind != b->kind) return std::nullopt;
  return a->size / b->size;
}

}  // namespace eha
