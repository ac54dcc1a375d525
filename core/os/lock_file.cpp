// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/lock_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/os/users.hpp"
#include "core/shell_word.hpp"

namespace eha::os {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kOwnersOnly = 0600;
constexpr mode_t kOthers = S_IRWXG | S_IRWXO;

void require_own(const struct stat& file, const fs::path& path) {
  if (file.st_uid == geteuid()) return;
  throw PermissionError(path.string() + ": belongs to " + local_user_text(file.st_uid) +
                        ", who could keep this program from locking it; remove it, or name a folder of your own");
}

/// @returns false  another process has the lock
bool lock(const FileDescriptor& file, const fs::path& path) {
  while (flock(file.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) return false;
    if (errno != EINTR) throw_system_error("lock", path, errno);
  }
  return true;
}

FileDescriptor open_or_make(const fs::path& path) {
  FileDescriptor file(
      ::open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC, kOwnersOnly));
  const int error_number = errno;
  struct stat facts {};
  // Also where it may not be opened its owner is known.
  if (file ? fstat(file.get(), &facts) != 0 : lstat(path.c_str(), &facts) != 0) {
    throw_system_error("lock", path, file ? errno : error_number);
  }
  if (!S_ISREG(facts.st_mode)) throw IoError(path.string() + ": a link, or no file, where a lock is kept; remove it");
  require_own(facts, path);
  if (!file) throw_system_error("lock", path, error_number);
  return file;
}

bool is_still_at(const struct stat& file, const fs::path& path) {
  struct stat there {};
  return lstat(path.c_str(), &there) == 0 && there.st_dev == file.st_dev && there.st_ino == file.st_ino;
}

/// Puts a new locked file in the place of one whose lock this process has.
FileDescriptor replacement(const fs::path& path) {
  fs::path temporary = path;
  temporary += "." + std::to_string(::getpid()) + ".tmp";
  ::unlink(temporary.c_str());
  FileDescriptor file = open_file(temporary, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW, kOwnersOnly);
  if (!lock(file, temporary) || ::rename(temporary.c_str(), path.c_str()) != 0) {
    throw_system_error("replace", path, errno);
  }
  return file;
}

}  // namespace

FileDescriptor lock_file(const fs::path& path, std::string_view holder) {
  for (;;) {
    FileDescriptor file = open_or_make(path);
    struct stat facts {};
    if (fstat(file.get(), &facts) != 0) throw_system_error("lock", path, errno);
    const bool others_could_open = (facts.st_mode & kOthers) != 0;
    if (!lock(file, path)) {
      throw DeviceError(path.string() + ": locked by " +
                        (others_could_open
                             ? "a process, which may be anybody's, because other users may open this file: fuser " +
                                   shell_word(path.string()) +
                                   " names it; end it and start again, which replaces the file"
                             : std::string(holder)));
    }
    // Another process may have replaced or removed it between opening and locking.
    if (!is_still_at(facts, path)) continue;
    return others_could_open ? replacement(path) : std::move(file);
  }
}

}  // namespace eha::os
