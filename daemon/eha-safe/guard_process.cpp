// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha-safe/guard_process.hpp"

#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/program_path.hpp"

namespace eha {
namespace {

/// Starting a program and reading a small file takes milliseconds; after this time it hangs.
constexpr int kStartLimit_ms = 10'000;
/// After the message that the rig is safe a guard ends in milliseconds; after this time it hangs.
constexpr std::chrono::milliseconds kEndLimit{5'000};

[[noreturn]] void fail(const std::filesystem::path& program, const std::string& cause) {
  throw DeviceError(program.string() + ": the guard of the rig does not start: " + cause +
                    "; nothing is driven without it");
}

std::string describe(const os::ChildEnd& end) {
  if (!end.status) return "its exit status is unavailable";
  if (WIFSIGNALED(*end.status)) return "it was ended by signal " + std::to_string(WTERMSIG(*end.status));
  return "it ended with status " + std::to_string(WEXITSTATUS(*end.status));
}

}  // namespace

GuardProcess::GuardProcess(const std::filesystem::path& program, const std::filesystem::path& snapshot,
                           const os::FileDescriptor* page) {
  std::array<int, 2> ends{};
  // A socket, not two pipes: its end-of-file is the same, and a write to a dead guard is an error, not a signal.
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) fail(program, error_text(errno));
  stream_ = os::FileDescriptor(ends[0]);
  os::FileDescriptor guards_end(ends[1]);
  std::vector<std::string> words{program.string(), "--guard"};
  if (!snapshot.empty()) words.push_back(std::filesystem::absolute(snapshot));
  if (page != nullptr) words.push_back("--page=/proc/self/fd/" + std::to_string(os::kSharedDescriptor));
  try {
    process_.emplace(os::SpawnRequest{.words = std::move(words),
                                      .standard_input = &guards_end,
                                      .standard_output = &guards_end,
                                      .shared = page,
                                      .session = os::Session::own});
  } catch (const IoError& error) {
    throw DeviceError(std::string(error.what()) + "; nothing is driven without the guard of the rig");
  }
  // Only the guard's copies remain: its death ends the stream.
  guards_end.close();
  wait_until_ready(program);
}

void GuardProcess::wait_until_ready(const std::filesystem::path& program) {
  const std::string expected = "ready\n";
  std::string heard;
  while (heard != expected) {
    pollfd waiting{.fd = stream_.get(), .events = POLLIN, .revents = 0};
    const int polled = poll(&waiting, 1, kStartLimit_ms);
    if (polled < 0 && errno == EINTR) continue;
    std::array<char, 64> bytes{};
    const ssize_t count = polled > 0 ? read(stream_.get(), bytes.data(), bytes.size()) : 0;
    if (count > 0) heard.append(bytes.data(), static_cast<std::size_t>(count));
    if (count <= 0 || !expected.starts_with(heard)) {
      // Nothing was driven yet, so killing the guard has no effect on the rig.
      if (polled == 0) process_->signal(SIGKILL);
      const os::ChildEnd end = finish();
      fail(program, polled == 0 ? "it does not answer" : describe(end));
    }
  }
}

os::ChildEnd GuardProcess::finish() noexcept {
  if (!process_) return {};
  stream_.close();
  // A stopped guard could neither act nor end.
  process_->signal(SIGCONT);
  return process_->wait();
}

GuardProcess::~GuardProcess() { finish(); }

bool GuardProcess::watches() const noexcept { return process_ && process_->runs(); }

void GuardProcess::hold(const os::FileDescriptor& journal) noexcept {
  char end_of_line = '\n';
  iovec place{.iov_base = &end_of_line, .iov_len = 1};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr message{};
  message.msg_iov = &place;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* const header = CMSG_FIRSTHDR(&message);
  header->cmsg_level = SOL_SOCKET;
  header->cmsg_type = SCM_RIGHTS;
  header->cmsg_len = CMSG_LEN(sizeof(int));
  const int descriptor = journal.get();
  std::memcpy(CMSG_DATA(header), &descriptor, sizeof descriptor);
  static_cast<void>(sendmsg(stream_.get(), &message, MSG_NOSIGNAL | MSG_DONTWAIT));
}

void GuardProcess::done() {
  if (pid() < 0) return;
  const std::string line = "done\n";
  const ssize_t sent = send(stream_.get(), line.data(), line.size(), MSG_NOSIGNAL);
  const bool was_sent = sent == static_cast<ssize_t>(line.size());
  stream_.close();
  // A stopped guard could not end.
  process_->signal(SIGCONT);
  const std::optional<os::ChildEnd> end = process_->wait_for(kEndLimit);
  if (!end) {
    // The rig is safe, so the guard has nothing left to do.
    process_->signal(SIGKILL);
    process_->wait();
    throw DeviceError("the guard of the rig did not end within 5 s of the end of the run and has been killed");
  }
  if (!was_sent || end->status != 0) {
    throw DeviceError("the guard of the rig did not watch to the end: " + describe(*end));
  }
}

std::filesystem::path guard_program() {
  const std::filesystem::path program = find_program("eha-safe");
  if (program.empty()) fail("eha-safe", "it is neither beside this program nor in the bin folder next to it");
  return program;
}

}  // namespace eha
