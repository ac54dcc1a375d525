// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "tests/fuzz/require.hpp"

namespace eha::fuzz {

/// A file in memory with a path, for readers that take one. It has a name while it lives: HDF5 opens no file without.
class MemoryFile {
 public:
  MemoryFile(const std::uint8_t* data, std::size_t size)
      : path_("/dev/shm/eha-fuzz-" + std::to_string(::getpid()) + "-" + std::to_string(made_++)),
        descriptor_(::open(path_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600)) {
    require(descriptor_ >= 0, "a file in memory can be created");
    for (std::size_t done = 0; done < size;) {
      const ssize_t written = ::write(descriptor_, data + done, size - done);
      require(written > 0, "a file in memory takes what is written to it");
      done += static_cast<std::size_t>(written);
    }
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() {
    ::close(descriptor_);
    ::unlink(path_.c_str());
  }

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  inline static int made_ = 0;
  std::filesystem::path path_;
  int descriptor_;
};

}  // namespace eha::fuzz
