// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/os/child_process.hpp"
#include "core/os/file_descriptor.hpp"

namespace eha::worker {

/// Nobody waits for a fit at the terminal, as for a check: a check has seven times a fit's share of a processor.
inline constexpr int kFitNice = 19;
inline constexpr int kCheckNice = 10;

/// Limits on a worker's resources.
struct WorkerLimits {
  std::chrono::seconds cpu_time{1800};
  std::chrono::seconds wall_time{3600};
  std::uint64_t memory_bytes = std::uint64_t{4} << 30U;  ///< address space
  std::optional<int> avoided_cpu;  ///< the tick loop's; the worker runs on the other CPUs, if there are any
  int nice = kFitNice;
};

/// The programs that a worker runs, see find_program().
struct WorkerPrograms {
  std::filesystem::path helper;  ///< eha-worker
  std::filesystem::path eha;
};

/// What ended a worker.
enum class EndedBy {
  itself,
  wall_time,
  processor_time,
  own_limit,  ///< of processor time, which ehad itself has and which is lower
  signal
};

/// The end of a worker.
struct WorkerEnd {
  std::optional<int> exit_code;  ///< of eha; none: killed, or ended by a limit
  std::string text;              ///< its last messages, or the reason for its end
  std::string output = {};       ///< the end of its standard output
  EndedBy ended_by = EndedBy::itself;
};

/// Runs a command of `eha` (fit RUN, check FILE) as a child process with limits on time and memory. The child runs at
/// a low priority, not on the tick loop's CPU, and is killed when the thread that started it ends
/// (PR_SET_PDEATHSIG). Not thread-safe.
class WorkerProcess {
 public:
  /// @param arguments  of eha
  /// @throws IoError  it cannot be started
  WorkerProcess(const WorkerPrograms& programs, const std::vector<std::string>& arguments, const WorkerLimits& limits);
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;
  /// Kills the child and waits for its end.
  ~WorkerProcess();

  [[nodiscard]] pid_t pid() const noexcept { return process_.pid(); }

  /// Returns the worker's end, or nothing while it runs. Kills the worker when its wall time is over. Call on SIGCHLD
  /// and about every second.
  [[nodiscard]] std::optional<WorkerEnd> poll();

 private:
  WorkerLimits limits_;
  std::chrono::steady_clock::time_point begun_;
  os::FileDescriptor output_;    ///< an anonymous file that the worker's standard output goes to
  os::FileDescriptor messages_;  ///< an anonymous file that the worker's standard error goes to
  os::ChildProcess process_;
  bool timed_out_ = false;
};

}  // namespace eha::worker
