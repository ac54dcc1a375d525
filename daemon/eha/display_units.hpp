// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace eha::cli {

/// The names of the units of length that results may be shown in.
[[nodiscard]] std::vector<std::string> display_units();

/// A unit of length for everything that is printed for people; files and --json keep the record's.
class DisplayUnit {
 public:
  DisplayUnit() = default;
  /// @param name  one of display_units()
  explicit DisplayUnit(std::string name) : name_(std::move(name)) {}

  /// The unit that values in `unit` are shown in: the asked one where both are lengths, else `unit`.
  [[nodiscard]] std::string of(const std::string& unit) const;
  /// What a value in `unit` is multiplied by.
  [[nodiscard]] double factor(std::string_view unit) const;

 private:
  std::string name_ = {};  ///< empty: as the record
};

}  // namespace eha::cli
