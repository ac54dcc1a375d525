// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/own_folder.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/os/users.hpp"
#include "core/shell_word.hpp"

namespace eha::os {
namespace {

namespace fs = std::filesystem;

constexpr mode_t kOwnerWrites = 0755;

/// Without the last slash, behind which a link is followed.
fs::path without_slash(fs::path path) {
  return path.has_filename() || !path.has_parent_path() ? std::move(path) : path.parent_path();
}

struct stat facts_of(const FileDescriptor& file, const fs::path& path) {
  struct stat facts {};
  if (fstat(file.get(), &facts) != 0) throw_system_error("look at", path, errno);
  return facts;
}

}  // namespace

bool is_changed_only_by(const struct stat& file, std::initializer_list<uid_t> owners) noexcept {
  return std::find(owners.begin(), owners.end(), file.st_uid) != owners.end() &&
         (file.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

OwnFolder::OwnFolder(fs::path folder, std::string remedy)
    : path_(without_slash(std::move(folder))), remedy_(std::move(remedy)) {
  struct stat facts {};
  if (lstat(path_.c_str(), &facts) == 0) {
    open();
  } else if (errno != ENOENT) {
    throw_system_error("open", path_, errno);
  }
}

void OwnFolder::open() {
  folder_ = FileDescriptor(::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  if (!folder_) {
    const int error_number = errno;
    if (std::error_code unknown; fs::is_symlink(path_, unknown)) refuse_link(path_);
    throw_system_error("open", path_, error_number);
  }
  require_own(folder_, path_);
}

void OwnFolder::make() {
  if (folder_) return;
  if (path_.has_parent_path()) create_folders(path_.parent_path());
  if (mkdir(path_.c_str(), kOwnerWrites) != 0 && errno != EEXIST) throw_system_error("create", path_, errno);
  open();
}

std::optional<std::string> OwnFolder::read(const std::string& name) const {
  const FileDescriptor file = open_file_of(name);
  if (!file) return std::nullopt;
  return read_file(path_through(file));
}

void OwnFolder::write(const std::string& name, std::string_view text) const {
  write_file_atomically(path_through(folder_) / name, text);
}

void OwnFolder::remove(const std::string& name) const noexcept {
  if (folder_) unlinkat(folder_.get(), name.c_str(), 0);
}

void OwnFolder::require_own(const std::string& name) const {
  struct stat there {};
  const bool is_there = folder_ && lstat(path_.c_str(), &there) == 0;
  if (folder_ && is_there) {
    const struct stat held = facts_of(folder_, path_);
    if (held.st_dev == there.st_dev && held.st_ino == there.st_ino) {
      static_cast<void>(open_file_of(name));
      return;
    }
  }
  throw PermissionError(path_.string() + ": another folder was put in its place meanwhile; " + remedy_);
}

FileDescriptor OwnFolder::open_file_of(const std::string& name) const {
  if (!folder_) return {};
  const fs::path path = path_ / name;
  // Not to wait for somebody at the other end of a pipe.
  FileDescriptor file(openat(folder_.get(), name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (!file) {
    if (errno == ENOENT) return {};
    if (errno == ELOOP) refuse_link(path);
    throw_system_error("open", path, errno);
  }
  require_own(file, path);
  if (!S_ISREG(facts_of(file, path).st_mode)) throw IoError(path.string() + ": no file, where one is read; " + remedy_);
  return file;
}

void OwnFolder::require_own(const FileDescriptor& file, const fs::path& path) const {
  const struct stat facts = facts_of(file, path);
  if (is_changed_only_by(facts, {geteuid(), 0})) return;
  if (facts.st_uid != geteuid() && facts.st_uid != 0) {
    throw PermissionError(path.string() + ": belongs to " + local_user_text(facts.st_uid) +
                          ", who could have written anything there; " + remedy_);
  }
  throw PermissionError(path.string() + ": other users may write there; if nobody has: chmod go-w " +
                        shell_word(path.string()) + "; else " + remedy_);
}

void OwnFolder::refuse_link(const fs::path& path) const {
  throw PermissionError(path.string() + ": a link, and where it leads may be changed meanwhile; " + remedy_);
}

}  // namespace eha::os
