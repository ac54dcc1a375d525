// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/file_io.hpp"

#include <fcntl.h>
#include <openssl/evp.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.hpp"

namespace eha::record {
namespace {

constexpr std::size_t kReadSize = 1u << 16;

std::filesystem::path folder_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

void write_all(int descriptor, std::string_view text, const std::filesystem::path& path) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      throw_system_error("write", path, errno);
    }
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void synchronise(int descriptor, const std::filesystem::path& path) {
  if (::fsync(descriptor) != 0) throw_system_error("write", path, errno);
}

/// Calls consume(pointer, count) on each piece of a file.
template <typename Consume>
void read_pieces(const std::filesystem::path& path, Consume&& consume) {
  const FileDescriptor file = open_file(path, O_RDONLY);
  std::vector<char> piece(kReadSize);
  for (;;) {
    const ssize_t count = ::read(file.get(), piece.data(), piece.size());
    if (count < 0) {
      if (errno == EINTR) continue;
      throw_system_error("read", path, errno);
    }
    if (count == 0) return;
    consume(piece.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  FileDescriptor old(std::exchange(descriptor_, other.release()));
  return *this;
}

FileDescriptor::~FileDescriptor() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

int FileDescriptor::release() noexcept { return std::exchange(descriptor_, -1); }

void throw_system_error(std::string_view doing, const std::filesystem::path& path, int error_number) {
  std::string message =
      "cannot " + std::string(doing) + " " + path.string() + ": " + std::generic_category().message(error_number);
  if (error_number == EACCES || error_number == EPERM) throw PermissionError(message);
  if (error_number == ENOSPC || error_number == EDQUOT) message += "; free some space or choose another folder";
  throw IoError(message);
}

FileDescriptor open_file(const std::filesystem::path& path, int flags, unsigned mode) {
  const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC, mode);
  if (descriptor < 0) throw_system_error((flags & O_CREAT) != 0 ? "create" : "open", path, errno);
  return FileDescriptor(descriptor);
}

void publish_file(const std::filesystem::path& temporary, const std::filesystem::path& path) {
  synchronise(open_file(temporary, O_RDONLY).get(), temporary);
  if (::rename(temporary.c_str(), path.c_str()) != 0) throw_system_error("replace", path, errno);
  const std::filesystem::path folder = folder_of(path);
  synchronise(open_file(folder, O_RDONLY | O_DIRECTORY).get(), folder);
}

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)), temporary_(path_) {
  temporary_ += "." + std::to_string(::getpid()) + ".tmp";
  file_ = open_file(temporary_, O_WRONLY | O_CREAT | O_TRUNC);
}

AtomicFile::~AtomicFile() {
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::write(std::string_view text) { write_all(file_.get(), text, temporary_); }

void AtomicFile::commit() {
  file_ = FileDescriptor();
  publish_file(temporary_, path_);
  temporary_.clear();
}

void write_file_atomically(const std::filesystem::path& path, std::string_view text) {
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

std::string read_file(const std::filesystem::path& path) {
  std::string text;
  read_pieces(path, [&](const char* data, std::size_t count) { text.append(data, count); });
  return text;
}

std::string sha256_of_file(const std::filesystem::path& path) {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(), &EVP_MD_CTX_free);
  if (!context || EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) != 1) {
    throw IoError("cannot hash " + path.string() + ": libcrypto offers no SHA-256");
  }
  read_pieces(path, [&](const char* data, std::size_t count) { EVP_DigestUpdate(context.get(), data, count); });
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned length = 0;
  EVP_DigestFinal_ex(context.get(), digest.data(), &length);
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (unsigned i = 0; i < length; ++i) {
    text += kDigits[digest[i] >> 4];
    text += kDigits[digest[i] & 15];
  }
  return text;
}

void create_folders(const std::filesystem::path& folder) {
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code) throw_system_error("create", folder, code.value());
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

void try_space(const std::filesystem::path& path, std::uint64_t bytes) {
  const FileDescriptor file = open_file(path, O_WRONLY | O_CREAT | O_TRUNC);
  const bool granted = ::fallocate(file.get(), 0, 0, static_cast<off_t>(bytes)) == 0;
  const int error_number = errno;
  ::unlink(path.c_str());
  // Some file systems cannot say beforehand.
  if (!granted && error_number != EOPNOTSUPP) throw_system_error("write", path, error_number);
}

}  // namespace eha::record
