// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha-safe/local_snapshots.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdlib>
#include <string>
#include <system_error>

namespace eha {
namespace {

namespace fs = std::filesystem;

/// Returns the readable entries of a folder.
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    found.push_back(entry->path());
  }
  return found;
}

/// Whether mkdtemp may have made the name from the prefix; such names are safe to print on a terminal.
bool is_ours(const std::string& name) {
  const std::string beginning = kLocalSnapshotFolder;
  constexpr std::size_t kRandom = 6;
  return name.size() == beginning.size() + kRandom && name.rfind(beginning, 0) == 0 &&
         std::all_of(name.begin() + static_cast<std::ptrdiff_t>(beginning.size()), name.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0; });
}

/// Whether nobody else can replace this user's files in a folder.
bool keeps_what_is_ours(const fs::path& folder) {
  struct stat facts {};
  if (stat(folder.c_str(), &facts) != 0 || !S_ISDIR(facts.st_mode)) return false;
  const bool has_trusted_owner = facts.st_uid == geteuid() || facts.st_uid == 0;
  const bool may_others_write = (facts.st_mode & (S_IWGRP | S_IWOTH)) != 0;
  return has_trusted_owner && (!may_others_write || (facts.st_mode & S_ISVTX) != 0);
}

/// Whether the folder belongs to this user; other users' snapshots are not trusted.
bool is_own(const fs::path& folder) {
  struct stat facts {};
  return lstat(folder.c_str(), &facts) == 0 && S_ISDIR(facts.st_mode) && facts.st_uid == geteuid();
}

}  // namespace

fs::path local_snapshot_base() {
  // A root shell may still have the variables of the user who started it.
  for (const char* name : {"XDG_RUNTIME_DIR", "TMPDIR"}) {
    const char* folder = std::getenv(name);
    if (folder != nullptr && *folder != '\0' && keeps_what_is_ours(folder)) return folder;
  }
  return "/tmp";
}

std::vector<fs::path> find_local_snapshots() {
  std::vector<fs::path> bases{local_snapshot_base()};
  if (bases.front() != "/tmp") bases.emplace_back("/tmp");
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const fs::path& base : bases) {
    for (const fs::path& folder : entries_of(base)) {
      if (!is_ours(folder.filename().string()) || !is_own(folder)) continue;
      if (fs::exists(folder / kLocalSnapshot, ignored)) found.push_back(folder / kLocalSnapshot);
    }
  }
  return found;
}

}  // namespace eha
