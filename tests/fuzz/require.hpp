// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace eha::fuzz {

/// Ends the process unless `holds`; libFuzzer reports that as a finding and keeps the input.
inline void require(bool holds, std::string_view sentence) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %.*s\n", static_cast<int>(sentence.size()), sentence.data());
  std::abort();
}

/// Checks a refusal: it begins with the file's name and is printable; names in it may have letters of any language.
inline void require_good_message(std::string_view message, std::string_view file) {
  require(message.substr(0, file.size()) == file, "a message begins with the file's name");
  const auto prints = [](char c) {
    return c == '\n' || (c >= ' ' && c <= '~') || static_cast<unsigned char>(c) >= 0x80;
  };
  if (!std::all_of(message.begin(), message.end(), prints)) {
    std::fwrite(message.data(), 1, message.size(), stderr);
    require(false, "a message has printable characters only");
  }
}

}  // namespace eha::fuzz
