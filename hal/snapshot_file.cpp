// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/snapshot_file.hpp"

#include <cerrno>
#include <cstdint>
#include <fstream>
#include <iterator>

#include "core/error.hpp"
#include "core/os/files.hpp"

namespace eha::hal {
namespace {

/// A snapshot has a few hundred bytes; a file beyond this is something else.
constexpr std::uintmax_t kLargestFile = 65536;

[[noreturn]] void fail(const std::filesystem::path& path, const char* doing) {
  throw IoError(path.string() + ": " + doing + ": " + error_text(errno));
}

}  // namespace

void write_safe_snapshot(std::string_view snapshot, const std::filesystem::path& path) {
  os::write_file_atomically(path, snapshot);
}

std::string read_safe_snapshot(const std::filesystem::path& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) throw IoError(path.string() + ": cannot read the snapshot of the rig: " + error.message());
  if (size > kLargestFile)
    throw ConfigError(path.string() + ": not a snapshot of a rig: " + std::to_string(size) + " bytes");
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file.is_open() || file.bad()) fail(path, "cannot read the snapshot of the rig");
  return text;
}

}  // namespace eha::hal
