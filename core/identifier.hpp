// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace eha {

/// A name that C, Python, Octave and MATLAB take for a function or a variable: letters, digits and '_', a letter first;
/// other characters become '_'.
[[nodiscard]] inline std::string identifier(std::string_view name) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  std::string result;
  for (const char c : name) result += is_letter(c) || (c >= '0' && c <= '9') ? c : '_';
  if (result.empty() || !is_letter(result.front())) result.insert(0, "model_");
  return result;
}

}  // namespace eha
