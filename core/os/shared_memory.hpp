// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>

#include "core/os/file_descriptor.hpp"

namespace eha::os {

/// Whether a folder is in memory (tmpfs); empty: the present one. False of one that cannot be looked at. Cost: a call
/// of the system.
[[nodiscard]] bool is_in_memory(const std::filesystem::path& folder);

/// Mapping of a file in memory, for reading and writing, shared with all other processes that map it. Its pages are
/// present from the start. Not thread-safe.
class SharedMemory {
 public:
  /// Creates zeroed memory of `size` bytes.
  /// @param path  replaced by the new file, if its folder is in memory (tmpfs): other processes can then open it, also
  ///              after this process has died. For a folder on a disk, whose pages would wait for it, and for an empty
  ///              path: a file without a name.
  /// @throws IoError, PermissionError
  static SharedMemory create(std::size_t size, const std::filesystem::path& path = {});

  /// Maps an existing file. @throws IoError  shorter than `size`, or cannot be opened   @throws PermissionError
  static SharedMemory open(const std::filesystem::path& path, std::size_t size);

  SharedMemory(SharedMemory&& other) noexcept;
  SharedMemory& operator=(SharedMemory&&) = delete;
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  /// Unmaps the memory; keeps a file to which create() gave a name.
  ~SharedMemory();

  [[nodiscard]] void* data() const noexcept { return data_; }
  /// The descriptor is close-on-exec.
  [[nodiscard]] const FileDescriptor& file() const noexcept { return file_; }

 private:
  SharedMemory(FileDescriptor file, std::size_t size, const std::filesystem::path& path);

  FileDescriptor file_;
  std::size_t size_ = 0;
  void* data_ = nullptr;
};

}  // namespace eha::os
