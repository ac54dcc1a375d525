// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

namespace eha {

/// Returns the first name with a number that is not taken, whether or not `name` is: "models-2", "rig-new-3.toml".
/// @param name  with a last part of its own: not "." nor ".."
[[nodiscard]] inline std::string next_free_name(const std::string& name) {
  std::filesystem::path path(name);
  if (!path.has_filename()) path = path.parent_path();  // "models/"
  std::string stem = path.stem().string();
  std::string extension = path.extension().string();
  // The part behind the point of "drift0.02" names no kind of file.
  if (extension.find_first_not_of("0123456789", 1) == std::string::npos) stem += std::exchange(extension, {});
  std::error_code ignored;
  for (int number = 2;; ++number) {
    std::filesystem::path free = path;
    std::string last = stem;
    last += '-';
    last += std::to_string(number);
    last += extension;
    free.replace_filename(last);
    if (!std::filesystem::exists(std::filesystem::symlink_status(free, ignored))) return free.string();
  }
}

/// Returns the name of a new file or folder: "rig-new.toml" or, where that is taken, "rig-new-2.toml", ...
[[nodiscard]] inline std::string free_name(const std::string& name) {
  std::error_code ignored;
  return std::filesystem::exists(std::filesystem::symlink_status(name, ignored)) ? next_free_name(name) : name;
}

}  // namespace eha
