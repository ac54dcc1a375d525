// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/position.hpp"

namespace eha::config {

/// Collects what is wrong with one file, so that it is all reported at once. Not thread-safe.
class FaultList {
 public:
  explicit FaultList(std::string file_name) : file_name_(std::move(file_name)) {}

  /// "file:line:column: key: expected ..., got ..."
  void add(Position position, const std::string& key, std::string_view expected, std::string_view got);

  /// "file:line:column: key: text"
  void add_text(Position position, const std::string& key, std::string_view text);

  /// Whether neither the key nor anything beneath it has a fault.
  [[nodiscard]] bool clean(std::string_view key) const;

  /// Throws ConfigError with one line a fault, in the order of the file, when there is any.
  void throw_if_any() const;

 private:
  struct Fault {
    Position position;
    std::string key;
    std::string text;
  };

  std::string file_name_;
  std::vector<Fault> faults_;
};

/// Where a key stands: its own place, else that of the innermost table around it that the file has.
[[nodiscard]] Position position_of(const PositionMap& positions, std::string_view key);

}  // namespace eha::config
