// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "config/rig_config.hpp"
#include "daemon/eha-safe/guard_process.hpp"
#include "hal/rig.hpp"

namespace eha {

/// A rig opened in this process. One that moves a machine gets a guard: a process that makes it safe if this one is
/// killed.
/// Not thread-safe.
class OwnedRig {
 public:
  /// @param snapshot  file for eha-safe (Rig::safe_snapshot), which stays; empty: a private file, removed with this
  ///                  object
  /// @throws DeviceError, PermissionError, ConfigError as hal::open, GuardProcess
  explicit OwnedRig(const config::RigConfig& config, std::filesystem::path snapshot = {});
  OwnedRig(const OwnedRig&) = delete;
  OwnedRig& operator=(const OwnedRig&) = delete;
  /// Closes the rig; then, without made_safe(), the guard acts.
  ~OwnedRig();

  [[nodiscard]] hal::Rig& rig() noexcept { return *rig_; }

  /// Whether the guard has died, so that nobody would make the rig safe if this process were killed. Never true of a
  /// rig that moves no machine.
  [[nodiscard]] bool is_unguarded() const noexcept { return guard_ && !guard_->watches(); }

  /// Tells the guard that the device has confirmed the safe output. Drive nothing afterwards.
  /// @throws DeviceError  the guard had died
  void made_safe();

 private:
  std::filesystem::path private_folder_;
  std::optional<GuardProcess> guard_;
  std::unique_ptr<hal::Rig> rig_;  // after guard_: closed before the guard may act
};

}  // namespace eha
