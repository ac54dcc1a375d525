// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>

namespace eha::record {

/// Detects that a run in progress can no longer be completed: its folder or journal was deleted, moved or covered by
/// another mount, or the folder no longer takes files. The journal's open descriptor shows none of these.
/// Not thread-safe.
class FolderWatch {
 public:
  /// @param folder  already contains the journal   @throws IoError, PermissionError
  explicit FolderWatch(std::filesystem::path folder);

  /// Checks the folder. Cost: four system calls, none of which writes; as slow as the disk.
  /// @param rows  rows written to the journal so far, for the message
  /// @throws IoError  the cause, the lost rows and the kept ones
  void check(std::uint64_t rows) const;

 private:
  struct Identity {
    dev_t device;
    ino_t number;
  };
  [[nodiscard]] static bool is_still(const std::filesystem::path& path, const Identity& identity) noexcept;
  [[nodiscard]] static Identity identity_of(const std::filesystem::path& path);

  std::filesystem::path folder_;
  std::filesystem::path journal_;
  Identity folder_identity_;
  Identity journal_identity_;
};

}  // namespace eha::record
