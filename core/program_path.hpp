// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <unistd.h>

#include <array>
#include <filesystem>
#include <string_view>
#include <system_error>

namespace eha {

/// Finds a program of the project from the running one: in its folder (a build tree), otherwise in the bin, sbin or
/// libexec/ehad of the same prefix. Empty if it is in none of these.
[[nodiscard]] inline std::filesystem::path find_program(std::string_view name) {
  std::error_code ignored;
  const std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path();
  const std::filesystem::path prefix = here.parent_path();
  const std::array<std::filesystem::path, 4> folders{here, prefix / "bin", prefix / "sbin",
                                                     prefix / "libexec" / "ehad"};
  for (const std::filesystem::path& folder : folders) {
    const std::filesystem::path program = folder / name;
    if (access(program.c_str(), X_OK) == 0 && std::filesystem::is_regular_file(program, ignored)) return program;
  }
  return {};
}

}  // namespace eha
