// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha-safe/guard_process.hpp"

#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>

#include "core/error.hpp"
#include "core/program_path.hpp"

namespace eha {
namespace {

/// Starting a program and reading a small file takes milliseconds; this long means that it hangs.
constexpr int kStartLimit_ms = 10'000;

[[noreturn]] void fail(const std::filesystem::path& program, const std::string& cause) {
  throw DeviceError(program.string() + ": the guard of the rig does not start: " + cause +
                    "; nothing is driven without it");
}

/// Everything posix_spawn needs, freed in any case.
class SpawnRequest {
 public:
  explicit SpawnRequest(int stream) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawnattr_init(&attributes_);
    // The copies at 0 and 1 are the only descriptors of ours that survive exec.
    posix_spawn_file_actions_adddup2(&actions_, stream, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, stream, STDOUT_FILENO);
    sigset_t none;
    sigset_t all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setflags(&attributes_,
                             static_cast<short>(POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF));
  }
  SpawnRequest(const SpawnRequest&) = delete;
  SpawnRequest& operator=(const SpawnRequest&) = delete;
  ~SpawnRequest() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }

  int spawn(pid_t& pid, const std::string& program, const std::string& snapshot) {
    std::string name = "eha-safe";
    std::string option = "--guard";
    std::string file = snapshot;
    std::array<char*, 4> arguments = {name.data(), option.data(), file.data(), nullptr};
    return posix_spawn(&pid, program.c_str(), &actions_, &attributes_, arguments.data(), environ);
  }

 private:
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
};

std::string in_words(int status) {
  if (WIFSIGNALED(status)) return "it was ended by signal " + std::to_string(WTERMSIG(status));
  return "it ended with status " + std::to_string(WEXITSTATUS(status));
}

}  // namespace

GuardProcess::GuardProcess(const std::filesystem::path& program, const std::filesystem::path& snapshot) {
  std::array<int, 2> ends{};
  // A socket rather than two pipes: the same end-of-file, and a write to a dead guard is an error, not a signal.
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) fail(program, std::strerror(errno));
  stream_ = ends[0];
  const int error = SpawnRequest(ends[1]).spawn(pid_, program.string(), std::filesystem::absolute(snapshot).string());
  close(ends[1]);
  if (error != 0) {
    close(stream_);
    fail(program, std::strerror(error));
  }
  wait_until_ready(program);
}

void GuardProcess::wait_until_ready(const std::filesystem::path& program) {
  const std::string expected = "ready\n";
  std::string heard;
  while (heard != expected) {
    pollfd waiting{.fd = stream_, .events = POLLIN, .revents = 0};
    const int polled = poll(&waiting, 1, kStartLimit_ms);
    if (polled < 0 && errno == EINTR) continue;
    std::array<char, 64> bytes{};
    const ssize_t count = polled > 0 ? read(stream_, bytes.data(), bytes.size()) : 0;
    if (count > 0) heard.append(bytes.data(), static_cast<std::size_t>(count));
    if (count <= 0 || !expected.starts_with(heard)) {
      // It has driven nothing yet, so ending it by force leaves nothing undone.
      if (polled == 0) kill(pid_, SIGKILL);
      const int status = finish();
      fail(program, polled == 0 ? "it does not answer" : in_words(status));
    }
  }
}

int GuardProcess::finish() noexcept {
  if (stream_ >= 0) close(stream_);
  stream_ = -1;
  int status = 0;
  // One that is stopped could neither act nor end.
  if (pid_ > 0) kill(pid_, SIGCONT);
  while (pid_ > 0 && waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  return status;
}

GuardProcess::~GuardProcess() { finish(); }

bool GuardProcess::watches() const noexcept {
  siginfo_t change{};
  return pid_ > 0 && waitid(P_PID, static_cast<id_t>(pid_), &change, WEXITED | WSTOPPED | WNOHANG | WNOWAIT) == 0 &&
         change.si_pid == 0;
}

void GuardProcess::done() {
  if (pid_ < 0) return;
  const std::string word = "done\n";
  const ssize_t sent = send(stream_, word.data(), word.size(), MSG_NOSIGNAL);
  const bool taken = sent == static_cast<ssize_t>(word.size());
  const int status = finish();
  if (!taken || status != 0) throw DeviceError("the guard of the rig did not watch to the end: " + in_words(status));
}

std::filesystem::path guard_program() {
  const std::filesystem::path program = find_program("eha-safe");
  if (program.empty()) fail("eha-safe", "it is neither beside this program nor in the bin folder next to it");
  return program;
}

}  // namespace eha
