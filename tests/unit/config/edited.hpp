// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace eha::config {

/// A text with one passage, which must occur exactly once, replaced by another.
inline std::string edited(std::string text, std::string_view passage, std::string_view replacement) {
  const std::size_t at = text.find(passage);
  if (at == std::string::npos || text.find(passage, at + 1) != std::string::npos) {
    ADD_FAILURE() << "\"" << passage << "\" does not occur exactly once";
    return text;
  }
  return text.replace(at, passage.size(), replacement);
}

}  // namespace eha::config
