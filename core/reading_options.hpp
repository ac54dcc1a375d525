// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace eha {

/// An option of `eha fit`, `import`, ... by which a file is read, or a record's part or rows chosen.
struct ReadingOption {
  std::string_view name;
  bool has_value;
};

inline constexpr std::array<ReadingOption, 14> kReadingOptions{{{"--time", true},
                                                                {"--input", true},
                                                                {"--output", true},
                                                                {"--delimiter", true},
                                                                {"--decimal", true},
                                                                {"--thousands", true},
                                                                {"--period", true},
                                                                {"--from", true},
                                                                {"--to", true},
                                                                {"--input-unit", true},
                                                                {"--output-unit", true},
                                                                {"--input-late", true},
                                                                {"--resample", false},
                                                                {"--keep-lone-rows", false}}};

/// The option that a word of a command is, "--from" or "--from=2"; null for any other word.
[[nodiscard]] constexpr const ReadingOption* reading_option(std::string_view word) {
  const std::string_view name = word.substr(0, word.find('='));
  const auto* found = std::find_if(kReadingOptions.begin(), kReadingOptions.end(),
                                   [&](const ReadingOption& option) { return option.name == name; });
  return found == kReadingOptions.end() ? nullptr : found;
}

}  // namespace eha
