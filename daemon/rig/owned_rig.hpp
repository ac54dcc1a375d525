// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "config/rig_config.hpp"
#include "core/guard_page.hpp"
#include "core/os/shared_memory.hpp"
#include "daemon/eha-safe/guard_process.hpp"
#include "hal/rig.hpp"

namespace eha {

/// A rig opened in this process, with a guard: a process that saves the last rows of a run if this one is killed, and
/// makes a rig that moves a machine safe then or if the loop stalls.
/// Not thread-safe.
class OwnedRig {
 public:
  /// A rig that moves no machine opens without a guard if none can be started.
  /// @param snapshot  file for eha-safe (Rig::safe_snapshot), kept like the page beside it (kPageFile); empty: a
  ///                  private file, removed with this object, and memory without a name
  /// @throws DeviceError, PermissionError, ConfigError as hal::open, GuardProcess
  /// @throws IoError  no memory for the page
  explicit OwnedRig(const config::RigConfig& config, std::filesystem::path snapshot = {});
  OwnedRig(const OwnedRig&) = delete;
  OwnedRig& operator=(const OwnedRig&) = delete;
  /// Closes the rig; without made_safe() the guard then acts.
  ~OwnedRig();

  [[nodiscard]] hal::Rig& rig() noexcept { return *rig_; }
  /// Page that the loop and the journal share with the guard.
  [[nodiscard]] GuardPage& page() noexcept { return *page_; }

  /// Shares the journal of a new run with the guard, see GuardProcess::hold.
  void hold(const os::FileDescriptor& journal) noexcept {
    if (guard_) guard_->hold(journal);
  }

  /// Whether the guard has died: nothing would make the rig safe if this process were killed. Never true of a rig that
  /// moves no machine.
  [[nodiscard]] bool is_unguarded() const noexcept { return moves_machine_ && !guard_->watches(); }

  /// Tells the guard that the device has confirmed the safe output. Drive nothing afterwards.
  /// @throws DeviceError  the guard had died; not for a rig that moves no machine
  void made_safe();

 private:
  bool moves_machine_;
  std::filesystem::path private_folder_;
  os::SharedMemory memory_;
  GuardPage* page_;  ///< in memory_
  std::optional<GuardProcess> guard_;
  std::unique_ptr<hal::Rig> rig_;  // after guard_: closed before the guard may act
};

}  // namespace eha
