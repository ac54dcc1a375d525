// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/resolved_path.hpp"

#include <string>
#include <system_error>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/terminal_text.hpp"

namespace eha::record {

std::filesystem::path resolved_path(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::path resolved = std::filesystem::canonical(path, error);
  if (error) os::throw_system_error("open", path, error.value());
  if (const std::string name = resolved.string(); one_line(name) != name) {
    throw DataError(one_line(name) + ": holds the end of a line, or another control character; rename it");
  }
  return resolved;
}

}  // namespace eha::record
