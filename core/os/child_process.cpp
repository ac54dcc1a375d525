// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/child_process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <thread>
#include <utility>

#include "core/error.hpp"

namespace eha::os {
namespace {

/// Owns posix_spawn's file actions.
class FileActions {
 public:
  explicit FileActions(const SpawnRequest& request) {
    posix_spawn_file_actions_init(&actions_);
    // Copies before opening /dev/null: a stream of the request may itself be descriptor 0.
    copy(request.standard_error, STDERR_FILENO);
    copy(request.standard_output, STDOUT_FILENO);
    copy(request.standard_input, STDIN_FILENO);
    copy(request.shared, kSharedDescriptor);
    if (request.standard_input == nullptr) open_null(STDIN_FILENO, O_RDONLY);
    if (request.standard_output == nullptr) open_null(STDOUT_FILENO, O_WRONLY);
    // A descriptor without close-on-exec, such as one that a library opened, would keep a device or its lock open.
    posix_spawn_file_actions_addclosefrom_np(&actions_,
                                             request.shared != nullptr ? kSharedDescriptor + 1 : STDERR_FILENO + 1);
  }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }

  [[nodiscard]] const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  void copy(const FileDescriptor* from, int to) {
    if (from != nullptr) posix_spawn_file_actions_adddup2(&actions_, from->get(), to);
  }
  void open_null(int as, int flags) { posix_spawn_file_actions_addopen(&actions_, as, "/dev/null", flags, 0); }

  posix_spawn_file_actions_t actions_{};
};

/// Owns posix_spawn's attributes.
class Attributes {
 public:
  explicit Attributes(Session session) {
    posix_spawnattr_init(&attributes_);
    sigset_t none;
    sigset_t all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    int flags = POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF;
    if (session == Session::own) flags |= POSIX_SPAWN_SETSID;
    posix_spawnattr_setflags(&attributes_, static_cast<short>(flags));
  }
  Attributes(const Attributes&) = delete;
  Attributes& operator=(const Attributes&) = delete;
  ~Attributes() { posix_spawnattr_destroy(&attributes_); }

  [[nodiscard]] const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_{};
};

}  // namespace

ChildProcess::ChildProcess(const SpawnRequest& request) {
  std::vector<std::string> words = request.words;
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const int error = posix_spawn(&pid_, words.at(0).c_str(), FileActions(request).get(),
                                Attributes(request.session).get(), arguments.data(), environ);
  if (error == 0) return;
  pid_ = -1;
  throw IoError(words.front() + ": cannot be started: " + error_text(error));
}

ChildProcess::~ChildProcess() { wait(); }

void ChildProcess::signal(int number) const noexcept {
  if (pid_ > 0) kill(pid_, number);
}

bool ChildProcess::runs() const noexcept {
  siginfo_t change{};
  return pid_ > 0 && waitid(P_PID, static_cast<id_t>(pid_), &change, WEXITED | WSTOPPED | WNOHANG | WNOWAIT) == 0 &&
         change.si_pid == 0;
}

std::optional<ChildEnd> ChildProcess::poll() noexcept {
  int status = 0;
  const pid_t got = waitpid(pid_, &status, WNOHANG);
  if (got == 0) return std::nullopt;
  pid_ = -1;
  return got > 0 ? ChildEnd{status} : ChildEnd{};
}

std::optional<ChildEnd> ChildProcess::wait_for(std::chrono::milliseconds limit) noexcept {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  for (;;) {
    // Reads the clock before the poll, so that a delayed poll still finds the end.
    const bool is_last = std::chrono::steady_clock::now() >= deadline;
    if (std::optional<ChildEnd> end = poll()) return end;
    if (is_last) return std::nullopt;
    // Uses no pidfd: a process without free descriptors must be able to wait, too.
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

ChildEnd ChildProcess::wait() noexcept {
  if (pid_ <= 0) return {};
  const pid_t pid = std::exchange(pid_, -1);
  int status = 0;
  for (;;) {
    if (waitpid(pid, &status, 0) == pid) return {status};
    if (errno != EINTR) return {};
  }
}

}  // namespace eha::os
