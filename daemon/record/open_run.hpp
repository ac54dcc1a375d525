// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>

#include "core/os/file_descriptor.hpp"

namespace eha::record {

/// A run folder, and the folder that it is in, held open: what is read and written through it stays in this one
/// whatever its owner puts in the place of its path. Copies hold the same descriptors. Thread-safe.
class OpenRun {
 public:
  /// Holds nothing; only the assignment is allowed.
  OpenRun() = default;
  /// Follows the links of the path, as `latest` is one, then opens what it leads to and no link.
  /// @throws IoError, PermissionError, DataError  as resolved_path(), or it is no folder
  explicit OpenRun(const std::filesystem::path& folder);

  /// The path without links at the time of opening, for messages.
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return held_->path; }
  /// The path by which this process reaches the run's files, while a copy of this object lives.
  [[nodiscard]] const std::filesystem::path& files() const noexcept { return held_->files; }
  /// The same of the folder that the run is in.
  [[nodiscard]] const std::filesystem::path& beside() const noexcept { return held_->beside; }

 private:
  struct Held {
    std::filesystem::path path;
    os::FileDescriptor parent;
    os::FileDescriptor folder;
    std::filesystem::path files;
    std::filesystem::path beside;
  };
  std::shared_ptr<const Held> held_;
};

}  // namespace eha::record
