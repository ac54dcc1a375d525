// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

namespace eha::cli {

/// Folders made before long work, so that one that cannot be made is found out at once, and taken away again when the
/// work leaves nothing in them. Not thread-safe.
class NewFolders {
 public:
  /// Makes `folder` and those above it where they are missing. @throws IoError, PermissionError
  explicit NewFolders(const std::filesystem::path& folder);
  NewFolders(const NewFolders&) = delete;
  NewFolders& operator=(const NewFolders&) = delete;
  /// Removes those that were made, as far as they are empty.
  ~NewFolders();

 private:
  std::filesystem::path folder_;
  std::size_t made_ = 0;  ///< how many, the innermost first
};

}  // namespace eha::cli
