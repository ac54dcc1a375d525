// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace eha::hal {

/// One option that cannot be right. `key` is the member's name, with dots for nested ones ("command.range_max_V");
/// `message` reads on after "key: ": "expected more than 0, got -3".
struct OptionFault {
  std::string key;
  std::string message;
};

/// All faults, one "prefix.key: message" a line.
[[nodiscard]] inline std::string to_lines(const std::vector<OptionFault>& faults, const std::string& prefix) {
  std::string lines;
  for (const OptionFault& fault : faults) {
    if (!lines.empty()) lines += '\n';
    lines += prefix + '.' + fault.key + ": " + fault.message;
  }
  return lines;
}

}  // namespace eha::hal
