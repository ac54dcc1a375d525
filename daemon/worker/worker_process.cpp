// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/worker/worker_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <vector>

#include "core/error.hpp"

namespace eha::worker {
namespace {

constexpr std::size_t kMostKept = 2000;  // bytes of what the worker said

/// Everything posix_spawn needs, freed in any case.
class SpawnRequest {
 public:
  explicit SpawnRequest(int output) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawnattr_init(&attributes_);
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions_, output, STDERR_FILENO);
    // libcomedi opens the card without O_CLOEXEC; a worker that holds it would keep its lock from eha-safe.
    posix_spawn_file_actions_addclosefrom_np(&actions_, STDERR_FILENO + 1);
    sigset_t none;
    sigset_t all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setflags(&attributes_, static_cast<short>(POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF));
  }
  SpawnRequest(const SpawnRequest&) = delete;
  SpawnRequest& operator=(const SpawnRequest&) = delete;
  ~SpawnRequest() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }

  int spawn(pid_t& pid, std::vector<std::string> words) {
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    return posix_spawn(&pid, words.front().c_str(), &actions_, &attributes_, arguments.data(), environ);
  }

 private:
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
};

}  // namespace

WorkerProcess::WorkerProcess(const WorkerPrograms& programs, const std::filesystem::path& run,
                             const WorkerLimits& limits)
    : limits_(limits), begun_(std::chrono::steady_clock::now()), output_(memfd_create("eha-fit", MFD_CLOEXEC)) {
  if (output_ < 0) throw IoError("cannot keep what the worker says: " + std::generic_category().message(errno));
  const int error = SpawnRequest(output_).spawn(
      pid_, {programs.helper.string(), fmt::format("{}", getpid()), fmt::format("{}", limits.avoided_cpu.value_or(-1)),
             fmt::format("{}", limits.cpu_time.count()), fmt::format("{}", limits.memory_bytes), programs.eha.string(),
             "fit", run.string(), "--quiet", "--no-progress"});
  if (error != 0) {
    close(output_);
    throw IoError(
        fmt::format("{}: cannot be started: {}", programs.helper.string(), std::generic_category().message(error)));
  }
}

WorkerProcess::~WorkerProcess() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  close(output_);
}

std::optional<WorkerEnd> WorkerProcess::poll() {
  int status = 0;
  const pid_t got = waitpid(pid_, &status, WNOHANG);
  if (got == 0) {
    if (!timed_out_ && std::chrono::steady_clock::now() - begun_ > limits_.wall_time) {
      timed_out_ = true;
      kill(pid_, SIGKILL);
    }
    return std::nullopt;
  }
  pid_ = -1;
  WorkerEnd end;
  if (got < 0) {
    end.text = "the identification was lost sight of";
  } else if (timed_out_) {
    end.text = fmt::format("the identification took longer than {} s (worker.wall_time_s) and was ended",
                           limits_.wall_time.count());
  } else if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU)) {
    end.text = fmt::format("the identification took more than {} s of processor time (worker.cpu_time_s) and was ended",
                           limits_.cpu_time.count());
  } else if (WIFSIGNALED(status)) {
    end.text =
        fmt::format("the identification was ended by signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status)));
  } else {
    end.exit_code = WEXITSTATUS(status);
    end.text = said();
  }
  return end;
}

std::string WorkerProcess::said() const {
  const off_t size = lseek(output_, 0, SEEK_END);
  std::string text(std::min<std::size_t>(kMostKept, size > 0 ? static_cast<std::size_t>(size) : 0), '\0');
  const ssize_t count = pread(output_, text.data(), text.size(), size - static_cast<off_t>(text.size()));
  text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

}  // namespace eha::worker
