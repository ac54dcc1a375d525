// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/worker/worker_process.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "core/error.hpp"

namespace eha::worker {
namespace {

constexpr std::size_t kMostKept = 8000;  // bytes of the worker's messages, and of its results

os::FileDescriptor create_anonymous_file() {
  os::FileDescriptor file(memfd_create("eha-worker", MFD_CLOEXEC));
  if (!file) {
    throw IoError("cannot create a file for the worker's messages: " + error_text(errno));
  }
  return file;
}

std::string end_of(const os::FileDescriptor& file) {
  const off_t size = lseek(file.get(), 0, SEEK_END);
  std::string text(std::min<std::size_t>(kMostKept, size > 0 ? static_cast<std::size_t>(size) : 0), '\0');
  const ssize_t count = pread(file.get(), text.data(), text.size(), size - static_cast<off_t>(text.size()));
  text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

os::SpawnRequest request_for(const WorkerPrograms& programs, const std::vector<std::string>& arguments,
                             const WorkerLimits& limits, const os::FileDescriptor& output,
                             const os::FileDescriptor& messages) {
  std::vector<std::string> words{programs.helper.string(),
                                 fmt::format("{}", getpid()),
                                 fmt::format("{}", limits.avoided_cpu.value_or(-1)),
                                 fmt::format("{}", limits.cpu_time.count()),
                                 fmt::format("{}", limits.memory_bytes),
                                 fmt::format("{}", limits.nice),
                                 programs.eha.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return {.words = std::move(words), .standard_output = &output, .standard_error = &messages};
}

/// The service's own hard limit, which a worker inherits and cannot raise; none where it is not below the wanted one.
std::optional<rlim_t> lower_own_limit(__rlimit_resource resource, rlim_t wanted) {
  rlimit own{};
  if (getrlimit(resource, &own) != 0 || own.rlim_max >= wanted) return std::nullopt;
  return own.rlim_max;
}

/// Beside an end that too little memory may have caused; empty where the worker has what it should.
std::string memory_note(const WorkerLimits& limits) {
  const std::optional<rlim_t> own = lower_own_limit(RLIMIT_AS, limits.memory_bytes);
  if (!own) return "";
  return fmt::format(
      " (ehad itself has a hard limit of {} MiB of memory, RLIMIT_AS, below the {} MiB that this process may take: "
      "raise LimitAS of its unit)",
      *own >> 20U, limits.memory_bytes >> 20U);
}

}  // namespace

WorkerProcess::WorkerProcess(const WorkerPrograms& programs, const std::vector<std::string>& arguments,
                             const WorkerLimits& limits)
    : limits_(limits),
      begun_(std::chrono::steady_clock::now()),
      output_(create_anonymous_file()),
      messages_(create_anonymous_file()),
      process_(request_for(programs, arguments, limits, output_, messages_)) {}

WorkerProcess::~WorkerProcess() { process_.signal(SIGKILL); }

std::optional<WorkerEnd> WorkerProcess::poll() {
  const std::optional<os::ChildEnd> ended = process_.poll();
  if (!ended) {
    if (!timed_out_ && std::chrono::steady_clock::now() - begun_ > limits_.wall_time) {
      timed_out_ = true;
      process_.signal(SIGKILL);
    }
    return std::nullopt;
  }
  if (!ended->status) return WorkerEnd{std::nullopt, "the identification process's exit status is unavailable"};
  const int status = *ended->status;
  if (timed_out_) {
    return WorkerEnd{std::nullopt,
                     fmt::format("the identification took longer than {} s (worker.wall_time_s) and was ended",
                                 limits_.wall_time.count()),
                     "", EndedBy::wall_time};
  }
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) {
    if (const auto own = lower_own_limit(RLIMIT_CPU, static_cast<rlim_t>(limits_.cpu_time.count()))) {
      return WorkerEnd{std::nullopt,
                       fmt::format("the identification took more than the {} s of processor time that ehad itself has "
                                   "as a hard limit, RLIMIT_CPU, and was ended: raise LimitCPU of its unit",
                                   *own),
                       "", EndedBy::own_limit};
    }
    return WorkerEnd{
        std::nullopt,
        fmt::format("the identification took more than {} s of processor time (worker.cpu_time_s) and was ended",
                    limits_.cpu_time.count()),
        "", EndedBy::processor_time};
  }
  if (WIFSIGNALED(status)) {
    return WorkerEnd{std::nullopt,
                     fmt::format("the identification was ended by signal {} ({}){}", WTERMSIG(status),
                                 strsignal(WTERMSIG(status)), memory_note(limits_)),
                     "", EndedBy::signal};
  }
  const bool is_worker_itself = WEXITSTATUS(status) == static_cast<int>(ExitCode::io);
  return WorkerEnd{WEXITSTATUS(status), end_of(messages_) + (is_worker_itself ? memory_note(limits_) : ""),
                   end_of(output_)};
}

}  // namespace eha::worker
