// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace eha {

/// One invalid option. `key` is the member's name, with dots for nested ones ("command.range_max_V");
/// `message` follows "key: ": "expected more than 0, got -3".
struct OptionIssue {
  std::string key;
  std::string message;
};

/// All issues, one "prefix.key: message" a line.
[[nodiscard]] inline std::string to_lines(const std::vector<OptionIssue>& issues, const std::string& prefix) {
  std::string lines;
  for (const OptionIssue& issue : issues) {
    if (!lines.empty()) lines += '\n';
    lines += prefix + '.' + issue.key + ": " + issue.message;
  }
  return lines;
}

}  // namespace eha
