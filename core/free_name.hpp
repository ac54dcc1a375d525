// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

namespace eha {

/// Returns the first name with a number that is not taken, whether or not `name` is: "models-2", "rig-new-3.toml".
/// @param name  with a last part of its own: not "." nor ".."
[[nodiscard]] inline std::string next_free_name(const std::string& name) {
  std::filesystem::path path(name);
  if (!path.has_filename()) path = path.parent_path();  // "models/"
  std::error_code ignored;
  for (int number = 2;; ++number) {
    std::filesystem::path free = path;
    free.replace_filename(path.stem().string() + "-" + std::to_string(number) + path.extension().string());
    if (!std::filesystem::exists(std::filesystem::symlink_status(free, ignored))) return free.string();
  }
}

/// Returns the name of a new file or folder: "rig-new.toml" or, where that is taken, "rig-new-2.toml", ...
[[nodiscard]] inline std::string free_name(const std::string& name) {
  std::error_code ignored;
  return std::filesystem::exists(std::filesystem::symlink_status(name, ignored)) ? next_free_name(name) : name;
}

}  // namespace eha
