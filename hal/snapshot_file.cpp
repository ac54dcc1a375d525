// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/snapshot_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>

#include "core/error.hpp"

namespace eha::hal {
namespace {

/// A snapshot has a few hundred bytes; a file beyond this is something else.
constexpr std::uintmax_t kLargestFile = 65536;

/// A file descriptor that closes itself.
class File {
 public:
  explicit File(int descriptor) noexcept : descriptor_(descriptor) {}
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  [[nodiscard]] int get() const noexcept { return descriptor_; }

 private:
  int descriptor_;
};

[[noreturn]] void fail(const std::filesystem::path& path, const char* doing) {
  throw IoError(path.string() + ": " + doing + ": " + std::strerror(errno));
}

void write_all(int descriptor, std::string_view text, const std::filesystem::path& path) {
  while (!text.empty()) {
    const ssize_t written = write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(path, "cannot write");
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

}  // namespace

void write_safe_snapshot(std::string_view snapshot, const std::filesystem::path& path) {
  std::filesystem::path temporary = path;
  temporary += ".new";
  {
    const File file(open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (file.get() < 0) fail(temporary, "cannot create");
    write_all(file.get(), snapshot, temporary);
    if (fsync(file.get()) != 0) fail(temporary, "cannot flush");
  }
  if (rename(temporary.c_str(), path.c_str()) != 0) fail(path, "cannot replace");
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const File directory(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (directory.get() < 0 || fsync(directory.get()) != 0) fail(folder, "cannot flush");
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
