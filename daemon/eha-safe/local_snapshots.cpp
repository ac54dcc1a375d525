// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha-safe/local_snapshots.hpp"

#include <algorithm>
#include <cstdlib>
#include <string>
#include <system_error>

namespace eha {
namespace {

namespace fs = std::filesystem;

/// The entries of a folder, as far as they may be seen.
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    found.push_back(entry->path());
  }
  return found;
}

}  // namespace

fs::path local_snapshot_base() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  return runtime != nullptr && *runtime != '\0' ? fs::path(runtime) : fs::temp_directory_path();
}

std::vector<fs::path> find_local_snapshots() {
  std::vector<fs::path> bases = entries_of("/run/user");
  bases.push_back(local_snapshot_base());
  bases.emplace_back("/tmp");
  std::sort(bases.begin(), bases.end());
  bases.erase(std::unique(bases.begin(), bases.end()), bases.end());
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const fs::path& base : bases) {
    for (const fs::path& folder : entries_of(base)) {
      if (folder.filename().string().rfind(kLocalSnapshotFolder, 0) != 0) continue;
      if (fs::exists(folder / kLocalSnapshot, ignored)) found.push_back(folder / kLocalSnapshot);
    }
  }
  return found;
}

}  // namespace eha
