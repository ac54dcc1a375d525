// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "core/os/file_descriptor.hpp"

// File functions that throw the project's errors: PermissionError for EACCES and EPERM and IoError for any other failed
// call; both name the path and the reason. Thread-safe for different files.

namespace eha::os {

/// Throws the error of a failed system call.
/// @param doing  "write", "create", ... as in "cannot write PATH: ..."
[[noreturn]] void throw_system_error(std::string_view doing, const std::filesystem::path& path, int error_number);

/// Opens a regular file to read; a pipe of a stranger, which nobody writes, does not hang.
/// @throws IoError  it is none
[[nodiscard]] FileDescriptor open_regular_file(const std::filesystem::path& path);

/// Opens a file with open(2), close-on-exec added.
[[nodiscard]] FileDescriptor open_file(const std::filesystem::path& path, int flags, unsigned mode = 0644);

/// Reads up to `size` bytes; fewer only at the end of the file. @param path  for messages
[[nodiscard]] std::size_t read_up_to(const FileDescriptor& file, char* bytes, std::size_t size,
                                     const std::filesystem::path& path);

/// Reads from an offset of the file; neither uses nor changes the file's position.
[[nodiscard]] std::size_t read_up_to_at(const FileDescriptor& file, char* bytes, std::size_t size, std::uint64_t offset,
                                        const std::filesystem::path& path);

/// Reads a whole file, and passes it on in pieces of at most 64 KiB.
void read_in_pieces(const std::filesystem::path& path, const std::function<void(std::string_view)>& consume);

/// The content of a file. @throws DataError  more than 256 MiB
[[nodiscard]] std::string read_file(const std::filesystem::path& path);

/// The same of a regular file: a pipe of a stranger, which nobody writes, does not hang. @throws IoError  it is none
[[nodiscard]] std::string read_regular_file(const std::filesystem::path& path);

/// Writes a file that appears under its name complete or not at all: under a temporary name in the same folder,
/// synchronised to the disk, then renamed. Without commit() no file is left. Not thread-safe.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  void write(std::string_view text);
  void commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path temporary_;
  FileDescriptor file_;
};

/// Replaces the content of `path` by `text`. A reader, or a power loss, finds the old or the new content and never a
/// part. A failure leaves the old content and no other file.
void write_file_atomically(const std::filesystem::path& path, std::string_view text);

/// Synchronises a file that was written under a temporary name to the disk and gives it its name.
void publish_file(const std::filesystem::path& temporary, const std::filesystem::path& path);

/// Removes the files and links of a folder whose names end in ".tmp": the remains of killed processes. Call it only
/// while no other process writes there. Leaves a file that cannot be removed.
void remove_temporary_files(const std::filesystem::path& folder) noexcept;

/// Creates a folder and every missing one above it.
void create_folders(const std::filesystem::path& folder);

/// Opens a folder, which is made if it is missing, and stays this folder whatever its owner puts in the place of its
/// path. @throws IoError  it is a link, or no folder
[[nodiscard]] FileDescriptor open_folder(const std::filesystem::path& folder);

/// The path by which this process reaches the files of an open folder.
[[nodiscard]] std::filesystem::path path_through(const FileDescriptor& folder);

/// The text of a path for messages: one of path_through() as it is found from the root now, on one line.
[[nodiscard]] std::string shown(const std::filesystem::path& path);

/// Checks the free space of the file system that holds `folder`.
/// @throws IoError  fewer than `bytes` are free for this user
void require_free_space(const std::filesystem::path& folder, std::uint64_t bytes);

/// Allocates `bytes` for a new file of this name, in place of a file or link that stands there, and removes it again.
/// This detects a full disk, a quota or a limit on file sizes before a library writes that handles them badly. Cost: no
/// data is written.
/// @param asked_for  the name that the user knows, for errors
void try_space(const std::filesystem::path& path, std::uint64_t bytes, const std::filesystem::path& asked_for);

}  // namespace eha::os
