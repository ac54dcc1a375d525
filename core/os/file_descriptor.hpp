// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::os {

/// Owns a file descriptor and closes it. Not thread-safe.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int descriptor) noexcept : descriptor_(descriptor) {}
  FileDescriptor(FileDescriptor&& other) noexcept : descriptor_(other.release()) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  ~FileDescriptor() { close(); }

  /// Returns -1 without a descriptor.
  [[nodiscard]] int get() const noexcept { return descriptor_; }
  [[nodiscard]] explicit operator bool() const noexcept { return descriptor_ >= 0; }

  /// Closes the descriptor now; does nothing without one. Keeps errno.
  void close() noexcept;
  /// Releases ownership: the caller closes the descriptor.
  [[nodiscard]] int release() noexcept;

 private:
  int descriptor_ = -1;
};

}  // namespace eha::os
