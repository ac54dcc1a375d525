// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/file_descriptor.hpp"

#include <unistd.h>

#include <cerrno>
#include <utility>

namespace eha::os {

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  FileDescriptor old(std::exchange(descriptor_, other.release()));
  return *this;
}

void FileDescriptor::close() noexcept {
  if (descriptor_ < 0) return;
  const int error_number = errno;
  // Not repeated after EINTR: Linux has already freed the number, see close(2).
  static_cast<void>(::close(std::exchange(descriptor_, -1)));
  errno = error_number;
}

int FileDescriptor::release() noexcept { return std::exchange(descriptor_, -1); }

}  // namespace eha::os
