// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <filesystem>

namespace eha {

/// A process that makes the rig safe should this one end without a word, SIGKILL included: `eha-safe --guard`.
///
/// Start it after the rig is open and its snapshot is written, before the enable line is switched on. It holds one end
/// of a stream, this process the other (close-on-exec): end-of-file without the word `done` makes it act. It has a
/// session of its own, so that Ctrl-C does not reach it, and ignores SIGTERM, which a service manager sends to every
/// process. Not thread-safe.
class GuardProcess {
 public:
  /// Returns once the guard has read the snapshot and waits.
  /// @param program   path of eha-safe, see guard_program()
  /// @throws DeviceError  the guard does not start; drive nothing without it
  GuardProcess(const std::filesystem::path& program, const std::filesystem::path& snapshot);
  GuardProcess(const GuardProcess&) = delete;
  GuardProcess& operator=(const GuardProcess&) = delete;

  /// Without done(): makes the guard act and waits for its end. Close the rig first: its locks keep the guard waiting.
  ~GuardProcess();

  /// Tells the guard that the rig is safe, and waits for its end; one that is stopped is continued for that. Does
  /// nothing the second time.
  /// @throws DeviceError  the guard had ended before, or did not take it well
  void done();

  [[nodiscard]] pid_t pid() const noexcept { return pid_; }

  /// Whether the guard still lives and is not stopped. Costs one waitid().
  [[nodiscard]] bool watches() const noexcept;

 private:
  void wait_until_ready(const std::filesystem::path& program);
  int finish() noexcept;

  pid_t pid_ = -1;
  int stream_ = -1;
};

/// eha-safe, see find_program(). @throws DeviceError  it is not there
[[nodiscard]] std::filesystem::path guard_program();

}  // namespace eha
