// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/terminal_text.hpp"

namespace eha::os {
namespace {

constexpr std::size_t kReadSize = 1u << 16;
constexpr std::string_view kOpenFolders = "/proc/self/fd/";

std::filesystem::path folder_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

void synchronise(const FileDescriptor& file, const std::filesystem::path& path) {
  if (::fsync(file.get()) != 0) throw_system_error("write", path, errno);
}

/// Calls read_some(done) until `size` bytes are read or the file ends.
template <typename ReadSome>
std::size_t read_all(ReadSome&& read_some, std::size_t size, const std::filesystem::path& path) {
  std::size_t done = 0;
  while (done < size) {
    const ssize_t count = read_some(done);
    if (count < 0) {
      if (errno == EINTR) continue;
      throw_system_error("read", path, errno);
    }
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  return done;
}

void read_pieces_of(const FileDescriptor& file, const std::filesystem::path& path,
                    const std::function<void(std::string_view)>& consume) {
  std::vector<char> piece(kReadSize);
  while (const std::size_t count = read_up_to(file, piece.data(), piece.size(), path)) {
    consume({piece.data(), count});
  }
}

std::string text_of(const FileDescriptor& file, const std::filesystem::path& path) {
  // A model or a manifest has some kB; a device, or a sparse file, may have no end.
  constexpr std::size_t kMostBytes = std::size_t{256} * 1024 * 1024;
  std::string text;
  read_pieces_of(file, path, [&](std::string_view piece) {
    if (text.size() + piece.size() > kMostBytes) {
      throw DataError(shown(path) + ": more than 256 MiB, where a text file is expected");
    }
    text += piece;
  });
  return text;
}

}  // namespace

void throw_system_error(std::string_view doing, const std::filesystem::path& path, int error_number) {
  std::string message = "cannot " + std::string(doing) + " " + shown(path) + ": " + error_text(error_number);
  if (error_number == EACCES || error_number == EPERM) throw PermissionError(message);
  if (error_number == ENOSPC || error_number == EDQUOT) message += "; free some space or choose another folder";
  throw IoError(message);
}

FileDescriptor open_file(const std::filesystem::path& path, int flags, unsigned mode) {
  FileDescriptor file(::open(path.c_str(), flags | O_CLOEXEC, mode));
  if (!file) throw_system_error((flags & O_CREAT) != 0 ? "create" : "open", path, errno);
  return file;
}

FileDescriptor open_regular_file(const std::filesystem::path& path) {
  FileDescriptor file = open_file(path, O_RDONLY | O_NONBLOCK | O_NOCTTY);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) throw_system_error("look at", path, errno);
  if (S_ISDIR(status.st_mode)) throw IoError("cannot read " + shown(path) + ": it is a folder");
  if (!S_ISREG(status.st_mode)) throw IoError("cannot read " + shown(path) + ": no regular file");
  return file;
}

std::size_t read_up_to(const FileDescriptor& file, char* bytes, std::size_t size, const std::filesystem::path& path) {
  return read_all([&](std::size_t done) { return ::read(file.get(), bytes + done, size - done); }, size, path);
}

std::size_t read_up_to_at(const FileDescriptor& file, char* bytes, std::size_t size, std::uint64_t offset,
                          const std::filesystem::path& path) {
  return read_all(
      [&](std::size_t done) {
        return ::pread(file.get(), bytes + done, size - done, static_cast<off_t>(offset + done));
      },
      size, path);
}

void read_in_pieces(const std::filesystem::path& path, const std::function<void(std::string_view)>& consume) {
  read_pieces_of(open_file(path, O_RDONLY), path, consume);
}

std::string read_file(const std::filesystem::path& path) { return text_of(open_file(path, O_RDONLY), path); }

std::string read_regular_file(const std::filesystem::path& path) { return text_of(open_regular_file(path), path); }

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)), temporary_(path_) {
  temporary_ += "." + std::to_string(::getpid()) + ".tmp";
  // The rename replaces any file of this name: as root it would replace a device node.
  std::error_code unknown;
  if (const auto there = std::filesystem::status(path_, unknown); std::filesystem::exists(there) &&
                                                                  !std::filesystem::is_regular_file(there) &&
                                                                  !std::filesystem::is_directory(there)) {
    throw IoError(shown(path_) + ": a device or a pipe, where a file is written; name another one");
  }
  // In a folder that others may write to, a link of theirs may have this name.
  ::unlink(temporary_.c_str());
  file_ = FileDescriptor(::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644));
  if (!file_) throw_system_error("write", path_, errno);  // the user knows no other name
}

AtomicFile::~AtomicFile() {
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::write(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(file_.get(), text.data(), text.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      throw_system_error("write", path_, errno);
    }
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void AtomicFile::commit() {
  file_.close();
  publish_file(temporary_, path_);
  temporary_.clear();
}

void write_file_atomically(const std::filesystem::path& path, std::string_view text) {
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

void publish_file(const std::filesystem::path& temporary, const std::filesystem::path& path) {
  synchronise(open_file(temporary, O_RDONLY), path);
  if (::rename(temporary.c_str(), path.c_str()) != 0) throw_system_error("replace", path, errno);
  const std::filesystem::path folder = folder_of(path);
  synchronise(open_file(folder, O_RDONLY | O_DIRECTORY), folder);
}

void remove_temporary_files(const std::filesystem::path& folder) noexcept {
  std::error_code ignored;
  std::vector<std::filesystem::path> unfinished;
  for (std::filesystem::directory_iterator entries(folder, ignored), end; !ignored && entries != end;
       entries.increment(ignored)) {
    if (entries->path().extension() == ".tmp") unfinished.push_back(entries->path());
  }
  for (const std::filesystem::path& file : unfinished) std::filesystem::remove(file, ignored);
}

void create_folders(const std::filesystem::path& folder) {
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code) throw_system_error("create", folder, code.value());
}

FileDescriptor open_folder(const std::filesystem::path& folder) {
  if (::mkdir(folder.c_str(), 0777) != 0 && errno != EEXIST) throw_system_error("create", folder, errno);
  return open_file(folder, O_RDONLY | O_DIRECTORY | O_NOFOLLOW);
}

std::filesystem::path path_through(const FileDescriptor& folder) {
  return std::string(kOpenFolders) + std::to_string(folder.get());
}

std::string shown(const std::filesystem::path& path) {
  const std::string text = path.string();
  if (!text.starts_with(kOpenFolders)) return text;
  const std::size_t end = std::min(text.find('/', kOpenFolders.size()), text.size());
  std::error_code unknown;
  const std::filesystem::path folder = std::filesystem::read_symlink(text.substr(0, end), unknown);
  return unknown ? text : one_line(folder.string()) + text.substr(end);
}

void require_free_space(const std::filesystem::path& folder, std::uint64_t bytes) {
  struct statvfs facts {};
  if (::statvfs(folder.c_str(), &facts) != 0) throw_system_error("look at", folder, errno);
  const std::uint64_t free = static_cast<std::uint64_t>(facts.f_bavail) * facts.f_frsize;
  if (free < bytes) {
    constexpr std::uint64_t kMega = 1'000'000;
    throw IoError("not enough room in " + folder.string() + ": the run needs " + std::to_string(bytes / kMega + 1) +
                  " MB, " + std::to_string(free / kMega) + " MB are free; free some space or choose another folder");
  }
}

void try_space(const std::filesystem::path& path, std::uint64_t bytes, const std::filesystem::path& asked_for) {
  ::unlink(path.c_str());  // of a killed process, or a link to another file, which must not be followed
  const FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644));
  if (!file) throw_system_error("write", asked_for, errno);
  const bool granted = ::fallocate(file.get(), 0, 0, static_cast<off_t>(bytes)) == 0;
  const int error_number = errno;
  ::unlink(path.c_str());
  // EOPNOTSUPP: the file system cannot allocate without writing, so nothing is known.
  if (!granted && error_number != EOPNOTSUPP) throw_system_error("write", asked_for, error_number);
}

}  // namespace eha::os
