// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace eha::record {

/// Owns a file descriptor. Not thread-safe.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int descriptor) noexcept : descriptor_(descriptor) {}
  FileDescriptor(FileDescriptor&& other) noexcept : descriptor_(other.release()) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  ~FileDescriptor();

  [[nodiscard]] int get() const noexcept { return descriptor_; }
  [[nodiscard]] explicit operator bool() const noexcept { return descriptor_ >= 0; }
  int release() noexcept;

 private:
  int descriptor_ = -1;
};

/// Opens a file with open(2), close-on-exec added. @throws PermissionError, IoError  naming the path and the reason
[[nodiscard]] FileDescriptor open_file(const std::filesystem::path& path, int flags, unsigned mode = 0644);

/// Throws the error of a failed system call: PermissionError for EACCES and EPERM, otherwise IoError.
/// @param doing  "write", "create", ... as in "cannot write PATH: ..."
[[noreturn]] void throw_system_error(std::string_view doing, const std::filesystem::path& path, int error_number);

/// A file that appears under its name whole or not at all: written under a temporary name beside it, made durable,
/// then renamed. Without commit() nothing is left behind. Not thread-safe.
class AtomicFile {
 public:
  /// @throws PermissionError, IoError
  explicit AtomicFile(std::filesystem::path path);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  /// @throws IoError
  void write(std::string_view text);
  /// @throws PermissionError, IoError
  void commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path temporary_;
  FileDescriptor file_;
};

/// Replaces `path` by `text` so that a reader, or a power loss, sees the old or the new content and never a part.
/// @throws PermissionError, IoError  and leaves nothing behind
void write_file_atomically(const std::filesystem::path& path, std::string_view text);

/// Makes a file that was written elsewhere under a temporary name durable and gives it its name.
/// @throws PermissionError, IoError
void publish_file(const std::filesystem::path& temporary, const std::filesystem::path& path);

/// @throws PermissionError, IoError
[[nodiscard]] std::string read_file(const std::filesystem::path& path);

/// SHA-256 of a file's content, 64 lower-case hexadecimal digits (FIPS 180-4, through libcrypto). Cost: one read.
/// @throws PermissionError, IoError
[[nodiscard]] std::string sha256_of_file(const std::filesystem::path& path);

/// Makes a folder and those above it where they are missing. @throws PermissionError, IoError
void create_folders(const std::filesystem::path& folder);

/// @throws IoError  fewer than `bytes` are free for this user on the file system that holds `folder`
void require_free_space(const std::filesystem::path& folder, std::uint64_t bytes);

/// Has the file system hand out `bytes` to a file of this name, and takes the file away again: finds a full disk, a
/// quota or a limit on file sizes before a library that copes badly with them does. Cost: no data is written.
/// @throws IoError, PermissionError
void try_space(const std::filesystem::path& path, std::uint64_t bytes);

}  // namespace eha::record
