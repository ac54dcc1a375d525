// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace eha::worker {

/// What an identification may use.
struct WorkerLimits {
  std::chrono::seconds cpu_time{1800};
  std::chrono::seconds wall_time{3600};
  std::uint64_t memory_bytes = std::uint64_t{4} << 30U;  ///< address space
  std::optional<int> avoided_cpu;  ///< the loop's; the worker runs on the others, if there are any
};

/// The programs that a worker is made of, see find_program().
struct WorkerPrograms {
  std::filesystem::path helper;  ///< eha-worker
  std::filesystem::path eha;
};

/// How a worker ended.
struct WorkerEnd {
  std::optional<int> exit_code;  ///< of eha fit; none: ended by force or by a limit
  std::string text;              ///< what it said, its end at most; or what ended it
};

/// `eha fit RUN` as a child: started by posix_spawn (never fork: the loop's memory is locked and shared), without any
/// descriptor but its standard ones, dead when the calling thread dies (PR_SET_PDEATHSIG), off the loop's CPU, at the
/// lowest priority, with limits. Not thread-safe.
class WorkerProcess {
 public:
  /// @throws IoError  it cannot be started
  WorkerProcess(const WorkerPrograms& programs, const std::filesystem::path& run, const WorkerLimits& limits);
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;
  /// Ends it by force, and waits for that.
  ~WorkerProcess();

  [[nodiscard]] pid_t pid() const noexcept { return pid_; }

  /// Whether it has ended; ends it by force when its time is over. To be asked on SIGCHLD and about every second.
  [[nodiscard]] std::optional<WorkerEnd> poll();

 private:
  [[nodiscard]] std::string said() const;

  WorkerLimits limits_;
  std::chrono::steady_clock::time_point begun_;
  pid_t pid_ = -1;
  int output_ = -1;  ///< an anonymous file
  bool timed_out_ = false;
};

}  // namespace eha::worker
