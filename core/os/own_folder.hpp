// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include "core/os/file_descriptor.hpp"

namespace eha::os {

/// Whether a file or folder belongs to one of these users and no one else may write to it.
[[nodiscard]] bool is_changed_only_by(const struct stat& file, std::initializer_list<uid_t> owners) noexcept;

/// A folder whose files decide what this process does, so that this user and root alone may change them. It is held
/// open: files are read from and written to the folder that was checked, whatever is put in the place of its path.
/// Neither it nor its files are links. All functions throw PermissionError where somebody else may change a file or the
/// folder, with what to do, and IoError for any other failed call. Not thread-safe.
class OwnFolder {
 public:
  /// Opens it if it is there.
  /// @param remedy  the last part of a refusal: what to do instead
  OwnFolder(std::filesystem::path folder, std::string remedy);

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
  /// Creates it if it is missing, for this user alone to write to, and every folder above it.
  void make();

  /// Content of a file; none if it is missing. @throws DataError  more than 256 MiB
  [[nodiscard]] std::optional<std::string> read(const std::string& name) const;
  /// Replaces a file (write_file_atomically) in a folder that is there.
  void write(const std::string& name, std::string_view text) const;
  void remove(const std::string& name) const noexcept;

  /// Refuses a file that is to be opened by its path: others may change it, or the path leads to another folder by now.
  void require_own(const std::string& name) const;

 private:
  void open();
  [[nodiscard]] FileDescriptor open_file_of(const std::string& name) const;
  void require_own(const FileDescriptor& file, const std::filesystem::path& path) const;
  [[noreturn]] void refuse_link(const std::filesystem::path& path) const;

  std::filesystem::path path_;
  std::string remedy_;
  FileDescriptor folder_;
};

}  // namespace eha::os
