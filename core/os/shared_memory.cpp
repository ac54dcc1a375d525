// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/shared_memory.hpp"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"

namespace eha::os {

bool is_in_memory(const std::filesystem::path& folder) {
  struct statfs facts {};
  return statfs(folder.empty() ? "." : folder.c_str(), &facts) == 0 && facts.f_type == TMPFS_MAGIC;
}

SharedMemory SharedMemory::create(std::size_t size, const std::filesystem::path& path) {
  FileDescriptor file;
  if (!path.empty() && is_in_memory(path.parent_path())) {
    // Creates a new file: a process that still maps the old one keeps the old one.
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    file = open_file(path, O_RDWR | O_CREAT | O_EXCL, 0600);
  } else {
    file = FileDescriptor(memfd_create("eha", MFD_CLOEXEC));
    if (!file) throw_system_error("create", "shared memory", errno);
  }
  // posix_fallocate, not ftruncate: a full file system is an error now and not a SIGBUS later.
  if (const int error = posix_fallocate(file.get(), 0, static_cast<off_t>(size)); error != 0) {
    throw_system_error("create", path.empty() ? "shared memory" : path, error);
  }
  return {std::move(file), size, path};
}

SharedMemory SharedMemory::open(const std::filesystem::path& path, std::size_t size) {
  FileDescriptor file = open_file(path, O_RDWR);
  struct stat facts {};
  if (fstat(file.get(), &facts) != 0) throw_system_error("look at", path, errno);
  if (!S_ISREG(facts.st_mode) || static_cast<std::size_t>(facts.st_size) < size) {
    throw IoError("cannot map " + path.string() + ": not the memory of a running program");
  }
  return {std::move(file), size, path};
}

SharedMemory::SharedMemory(FileDescriptor file, std::size_t size, const std::filesystem::path& path)
    : file_(std::move(file)), size_(size) {
  void* mapped = mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file_.get(), 0);
  if (mapped == MAP_FAILED) throw_system_error("map", path.empty() ? "shared memory" : path, errno);
  data_ = mapped;
}

SharedMemory::SharedMemory(SharedMemory&& other) noexcept
    : file_(std::move(other.file_)), size_(other.size_), data_(std::exchange(other.data_, nullptr)) {}

SharedMemory::~SharedMemory() {
  if (data_ != nullptr) munmap(data_, size_);
}

}  // namespace eha::os
