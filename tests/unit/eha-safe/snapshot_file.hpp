// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <unistd.h>

#include <filesystem>
#include <string>

#include "hal/comedi/safe_snapshot.hpp"
#include "hal/snapshot_file.hpp"

namespace eha::testing {

/// A snapshot of a card that does not exist, in a file that goes with this.
class SnapshotFile {
 public:
  SnapshotFile() : path_(std::filesystem::temp_directory_path() / ("eha-safe-" + std::to_string(getpid()) + ".json")) {
    hal::SafeSnapshot snapshot;
    snapshot.device = "/dev/no-such-card";
    snapshot.board = "pci1716";
    hal::write_safe_snapshot(hal::to_text(snapshot), path_);
  }
  SnapshotFile(const SnapshotFile&) = delete;
  SnapshotFile& operator=(const SnapshotFile&) = delete;
  ~SnapshotFile() { std::filesystem::remove(path_); }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace eha::testing
