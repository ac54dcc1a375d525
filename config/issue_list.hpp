// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/position.hpp"

namespace eha::config {

/// Collects the errors of one configuration file, so that all are reported at once; the hundredth throws them, as
/// throw_if_any(). Not thread-safe.
class IssueList {
 public:
  explicit IssueList(std::string file_name) : file_name_(std::move(file_name)) {}

  /// "file:line:column: key: expected ..., got ..."
  void add(Position position, const std::string& key, std::string_view expected, std::string_view got);

  /// "file:line:column: key: text"
  void add_text(Position position, const std::string& key, std::string_view text);

  /// Whether neither the key nor any key below it has an issue.
  [[nodiscard]] bool clean(std::string_view key) const;

  /// Throws ConfigError with one line for each issue, in the order of the file, if there is any.
  void throw_if_any() const;

 private:
  struct Issue {
    Position position;
    std::string key;
    std::string text;
  };

  std::string file_name_;
  std::vector<Issue> issues_;
};

/// Returns the position of a key; if the file lacks the key, that of the innermost enclosing table in the file.
[[nodiscard]] Position position_of(const PositionMap& positions, std::string_view key);

}  // namespace eha::config
