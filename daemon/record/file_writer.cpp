// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/file_writer.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/program_path.hpp"

namespace eha::record {

FileWriter::FileWriter(std::string_view kind, std::filesystem::path path, std::uint64_t most_bytes)
    : path_(std::move(path)), temporary_(path_) {
  temporary_ += ".tmp";
  const std::filesystem::path program = find_program("eha-hdf5");
  if (program.empty()) throw IoError("eha-hdf5 is not installed beside eha; install the package again");
  // The libraries report a full disk as a failure without a reason.
  os::try_space(temporary_, most_bytes, path_);
  file_ = os::FileDescriptor(::open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644));
  if (!file_) throw IoError("cannot write " + path_.string() + ": " + error_text(errno));
  try {
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
      throw IoError("cannot create a socket: " + error_text(errno));
    }
    to_ = os::FileDescriptor(ends[0]);
    const os::FileDescriptor from(ends[1]);
    process_ = std::make_unique<os::ChildProcess>(os::SpawnRequest{.words = {program.string(), std::string(kind)},
                                                                   .standard_input = &from,
                                                                   .shared = &file_,
                                                                   // Ctrl-C ends a run, not the writing of it.
                                                                   .session = os::Session::own});
  } catch (...) {
    ::unlink(temporary_.c_str());
    throw;
  }
}

FileWriter::~FileWriter() {
  if (!process_) return;
  process_->signal(SIGKILL);
  ::unlink(temporary_.c_str());
}

void FileWriter::send(const void* bytes, std::size_t size) {
  const char* at = static_cast<const char*>(bytes);
  while (size > 0) {
    const ssize_t sent = ::send(to_.get(), at, size, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) refuse();
    at += sent;
    size -= static_cast<std::size_t>(sent);
  }
}

void FileWriter::send_text(std::string_view text) {
  send_number(text.size());
  send(text.data(), text.size());
}

void FileWriter::commit() {
  to_ = os::FileDescriptor();
  if (process_->wait().status != 0) refuse();
  os::publish_file(temporary_, path_);
  process_.reset();
}

void FileWriter::refuse() const {
  throw IoError("cannot write " + path_.string() + ": eha-hdf5 failed; is the disk full?");
}

void receive(int descriptor, void* bytes, std::size_t size) {
  char* at = static_cast<char*>(bytes);
  while (size > 0) {
    const ssize_t count = ::read(descriptor, at, size);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) throw IoError("what is to be written ends too soon");
    at += count;
    size -= static_cast<std::size_t>(count);
  }
}

}  // namespace eha::record
