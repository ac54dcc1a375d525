// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

namespace eha::cli {

/// Creates folders before long work, so that an error in creating them shows at once. Removes them again if the work
/// leaves them empty. Not thread-safe.
class NewFolders {
 public:
  /// Creates `folder` and every missing one above it. @throws IoError, PermissionError
  explicit NewFolders(const std::filesystem::path& folder);
  NewFolders(const NewFolders&) = delete;
  NewFolders& operator=(const NewFolders&) = delete;
  /// Removes the folders it created that are empty.
  ~NewFolders();

 private:
  std::filesystem::path folder_;
  std::size_t made_ = 0;  ///< number of created folders, the innermost first
};

}  // namespace eha::cli
