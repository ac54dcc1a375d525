// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "core/os/file_descriptor.hpp"

namespace eha::os {

/// Session of a child.
enum class Session {
  shared,  ///< this process's: Ctrl-C on its terminal reaches the child
  own,     ///< a new one: no terminal's signal reaches the child
};

inline constexpr int kSharedDescriptor = 3;

/// Parameters of a child. The child inherits its three standard streams, the shared file if there is one, and no other
/// descriptor. It blocks no signal and handles every signal in the default way, independently of the thread that starts
/// it.
struct SpawnRequest {
  std::vector<std::string> words;                   ///< path of the program, then its arguments
  const FileDescriptor* standard_input = nullptr;   ///< none: /dev/null
  const FileDescriptor* standard_output = nullptr;  ///< none: /dev/null
  const FileDescriptor* standard_error = nullptr;   ///< none: this process's
  const FileDescriptor* shared = nullptr;           ///< becomes the child's descriptor kSharedDescriptor
  Session session = Session::shared;
};

/// Exit status of a child.
struct ChildEnd {
  std::optional<int> status;  ///< as waitpid(2) returns it; none: the system no longer knows the child
};

/// A child process, started by posix_spawn: never fork(), because the memory of the tick loop is locked and large.
/// Not thread-safe.
class ChildProcess {
 public:
  /// @throws IoError  the program cannot be started: "PATH: cannot be started: reason"
  explicit ChildProcess(const SpawnRequest& request);
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  /// Waits until the child has ended. Call signal(SIGKILL) first if the child does not end by itself.
  ~ChildProcess();

  /// Returns -1 after a wait for the child's end.
  [[nodiscard]] pid_t pid() const noexcept { return pid_; }

  /// Sends a signal; does nothing after a wait for the child's end.
  void signal(int number) const noexcept;

  /// Whether the child runs: neither ended nor stopped. Costs one waitid().
  [[nodiscard]] bool runs() const noexcept;

  /// Returns the child's status, or nothing while it runs. Do not call again after its end.
  [[nodiscard]] std::optional<ChildEnd> poll() noexcept;

  /// Waits until the child has ended. A second call returns an empty status at once.
  ChildEnd wait() noexcept;

  /// Waits for the child's end for at most `limit`. @returns nothing if it still runs. Do not call again after its end.
  [[nodiscard]] std::optional<ChildEnd> wait_for(std::chrono::milliseconds limit) noexcept;

 private:
  pid_t pid_ = -1;
};

}  // namespace eha::os
