// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>

#include "core/os/child_process.hpp"
#include "core/os/file_descriptor.hpp"

namespace eha {

/// Memory shared with the guard (GuardPage) that the service leaves behind, beside the snapshot; in its folder of /run.
inline constexpr const char* kPageFile = "guard.page";

/// A process that makes the rig safe when this one ends without sending `done`, SIGKILL included: `eha-safe --guard`.
/// With a page it also switches the hydraulics off if the loop stalls, and saves the rows that were not yet written
/// when this process died.
///
/// Start it after the rig is open and its snapshot is written, before the enable line is switched on. It holds one end
/// of a stream, this process the other (close-on-exec): end-of-file without the line `done` makes it act. It has its
/// own session, so that Ctrl-C does not reach it, and ignores SIGTERM, which a service manager sends to every process.
/// Not thread-safe.
class GuardProcess {
 public:
  /// Returns once the guard has read the snapshot and waits.
  /// @param program   path of eha-safe, see guard_program()
  /// @param snapshot  empty: no machine is driven, and the guard only saves rows
  /// @param page      memory that holds a GuardPage; none: neither beats nor rows are watched
  /// @throws DeviceError  the guard does not start; drive nothing without it
  GuardProcess(const std::filesystem::path& program, const std::filesystem::path& snapshot,
               const os::FileDescriptor* page = nullptr);
  GuardProcess(const GuardProcess&) = delete;
  GuardProcess& operator=(const GuardProcess&) = delete;

  /// Without done(): lets the guard act and waits for its end. Close the rig first: the guard waits for its locks.
  ~GuardProcess();

  /// Tells the guard that the rig is safe and waits for its end; continues it first if it is stopped, and kills it
  /// after 5 s. Does nothing the second time.
  /// @throws DeviceError  the guard had ended before, ended with an error, or had to be killed
  void done();

  /// Gives the guard the journal of a new run. The guard then shares the journal's lock until the page says that the
  /// journal has ended. Does nothing if the guard has died.
  void hold(const os::FileDescriptor& journal) noexcept;

  [[nodiscard]] pid_t pid() const noexcept { return process_ ? process_->pid() : -1; }

  /// Whether the guard still lives and is not stopped. Costs one waitid().
  [[nodiscard]] bool watches() const noexcept;

 private:
  void wait_until_ready(const std::filesystem::path& program);
  os::ChildEnd finish() noexcept;

  std::optional<os::ChildProcess> process_;
  os::FileDescriptor stream_;
};

/// Returns the path of eha-safe, see find_program(). @throws DeviceError  it does not exist
[[nodiscard]] std::filesystem::path guard_program();

}  // namespace eha
