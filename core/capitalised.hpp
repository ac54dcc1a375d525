// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cctype>
#include <string>

namespace eha {

/// A text with a capital first letter, as a sentence begins. Letters beyond ASCII stay as they are.
[[nodiscard]] inline std::string capitalised(std::string text) {
  if (!text.empty()) text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

}  // namespace eha
