// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

namespace eha::test {

/// Gives this process a mount table of its own, once. @returns false when the system does not allow that
[[nodiscard]] bool has_own_mounts();

/// Makes an ext4 file system of 256 MiB in the file `image` and mounts it at the folder `at`; after an error it becomes
/// read-only. @returns false when the system does not allow that
[[nodiscard]] bool mount_disk(const std::filesystem::path& image, const std::filesystem::path& at);

/// What is mounted at a folder, which is unmounted at the end.
class Mounted {
 public:
  explicit Mounted(std::filesystem::path at) : at_(std::move(at)) {}
  Mounted(const Mounted&) = delete;
  Mounted& operator=(const Mounted&) = delete;
  ~Mounted();

 private:
  std::filesystem::path at_;
};

/// A file system that hangs: every write to it waits until thaw().
class Frozen {
 public:
  /// @throws std::runtime_error  it cannot be frozen
  explicit Frozen(const std::filesystem::path& at);
  Frozen(const Frozen&) = delete;
  Frozen& operator=(const Frozen&) = delete;
  ~Frozen();
  void thaw();

 private:
  int folder_ = -1;
};

}  // namespace eha::test
