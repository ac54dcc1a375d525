// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/writer_lock.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

#include "core/os/files.hpp"

namespace eha::os {
namespace {

struct flock whole_file(short type) {
  struct flock range {};
  range.l_type = type;
  range.l_whence = SEEK_SET;
  return range;
}

}  // namespace

bool take_writer_lock(const FileDescriptor& file, const std::filesystem::path& path) {
  struct flock range = whole_file(F_WRLCK);
  // Asked twice: who had it at first may have closed the file before it was looked at.
  for (bool is_readers = false; ::fcntl(file.get(), F_OFD_SETLK, &range) != 0;) {
    if (errno == EINTR) continue;
    if (errno != EAGAIN && errno != EACCES) throw_system_error("lock", path, errno);
    if (has_writer(file, path)) return false;
    if (is_readers) return true;
    is_readers = true;
  }
  return true;
}

bool has_writer(const FileDescriptor& file, const std::filesystem::path& path) {
  // A reader's lock does not stand in the way of another one.
  struct flock range = whole_file(F_RDLCK);
  if (::fcntl(file.get(), F_OFD_GETLK, &range) != 0) throw_system_error("look at the lock of", path, errno);
  return range.l_type != F_UNLCK;
}

}  // namespace eha::os
