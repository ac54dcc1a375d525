// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/own_file.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <system_error>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/terminal_text.hpp"

namespace eha::record {

void require_no_link(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_symlink(path, ignored)) return;
  throw DataError(
      fmt::format("{}: is a link; the files of such a folder are its own, and a link may lead to any other file",
                  one_line(os::shown(path))));
}

void require_no_link_of_others(const std::filesystem::path& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0 || !S_ISLNK(status.st_mode)) return;
  if (status.st_uid == ::geteuid() || status.st_uid == 0) return;
  throw DataError(fmt::format("{}: is a link of another user, which may lead to any file; name the file itself",
                              one_line(os::shown(path))));
}

std::filesystem::path listed_file(const std::filesystem::path& folder, const std::string& name) {
  const std::filesystem::path named(name);
  std::filesystem::path file = folder;
  for (const std::filesystem::path& part : named) {
    if (named.is_absolute() || part == "..") {
      throw DataError(fmt::format("{}: names the file {}, which is not in this folder: it may be any of yours",
                                  one_line(os::shown(folder)), one_line(name)));
    }
    file /= part;
    require_no_link(file);
  }
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored)) {
    throw DataError(fmt::format("{}: a folder, a device or a pipe, where a file is read", one_line(os::shown(file))));
  }
  return file;
}

}  // namespace eha::record
