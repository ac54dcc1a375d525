// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/folder_watch.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::record {
namespace {

/// Returns the errno for which a folder takes no file; 0 if it takes one.
int refusal_of(const std::filesystem::path& folder) noexcept {
  if (::faccessat(AT_FDCWD, folder.c_str(), W_OK | X_OK, AT_EACCESS) != 0) return errno;
  struct statvfs facts {};
  if (::statvfs(folder.c_str(), &facts) != 0) return errno;
  return (facts.f_flag & ST_RDONLY) != 0 ? EROFS : 0;
}

}  // namespace

FolderWatch::FolderWatch(std::filesystem::path folder)
    : folder_(std::move(folder)),
      journal_(folder_ / kJournalFile),
      folder_identity_(identity_of(folder_)),
      journal_identity_(identity_of(journal_)) {}

void FolderWatch::check(std::uint64_t rows) const {
  for (const auto& [path, identity] : {std::pair{folder_, folder_identity_}, std::pair{journal_, journal_identity_}}) {
    if (is_still(path, identity)) continue;
    throw IoError(
        fmt::format("{} was deleted, moved or covered by a mount during the run: unless it was moved, the {} rows "
                    "recorded so far are lost; nothing more is recorded",
                    path.string(), rows));
  }
  if (const int refusal = refusal_of(folder_); refusal != 0) {
    throw IoError(
        fmt::format("{} takes no more files since the run began ({}): its files cannot be completed, and rows after "
                    "the first {} may be lost; once it can be written again, `eha runs recover {}` completes them",
                    folder_.string(), std::generic_category().message(refusal), rows, shell_word(folder_.string())));
  }
}

bool FolderWatch::is_still(const std::filesystem::path& path, const Identity& identity) noexcept {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && status.st_dev == identity.device && status.st_ino == identity.number;
}

FolderWatch::Identity FolderWatch::identity_of(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) os::throw_system_error("look at", path, errno);
  return {status.st_dev, status.st_ino};
}

}  // namespace eha::record
