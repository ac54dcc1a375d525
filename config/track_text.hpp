// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "core/toml_text.hpp"

namespace eha::config {

/// Options of a controller's trial that differ from the defaults.
struct TrackedMotion {
  std::optional<double> step_in = {};
  std::optional<double> sine_in = {};
  std::optional<double> sine_Hz = {};
  std::optional<double> hold_s = {};
  bool sweep = true;  ///< measure the margins
};

/// Writes the experiment that plays a controller's trial. Name and text of a controller file are untrusted: they are
/// written as TOML strings.
/// @param name, text  of the controller   @param file  that it is in; empty: none
[[nodiscard]] inline std::string track_experiment(std::string_view name, std::string_view text,
                                                  const TrackedMotion& motion, std::string_view file = {}) {
  constexpr std::size_t kLongestName = 40;
  std::string stem = "track-";
  for (const char c : name.substr(0, kLongestName)) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    stem += is_plain ? c : '-';
  }
  std::string experiment = fmt::format("schema = 1\nname = {}\n\n[track]\n", toml_string(stem));
  const auto add = [&](const char* key, const std::optional<double>& value) {
    if (value) experiment += fmt::format("{} = {:#}\n", key, *value);
  };
  add("step_in", motion.step_in);
  add("sine_in", motion.sine_in);
  add("sine_Hz", motion.sine_Hz);
  add("hold_s", motion.hold_s);
  if (motion.sweep) experiment += "sweep = true\n";
  if (!file.empty()) experiment += fmt::format("controller_file = {}\n", toml_string(file));
  return experiment + "controller = " + toml_string(text) + "\n";
}

}  // namespace eha::config
