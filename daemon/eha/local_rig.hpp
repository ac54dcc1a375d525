// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "config/rig_config.hpp"
#include "daemon/eha-safe/guard_process.hpp"
#include "hal/rig.hpp"

namespace eha::cli {

/// A rig opened in this process. A card gets a guard first: a process that makes it safe should this one be killed.
/// Not thread-safe.
class LocalRig {
 public:
  /// @throws DeviceError, PermissionError, ConfigError as hal::open_comedi, hal::open_sim, GuardProcess
  explicit LocalRig(const config::RigConfig& config);
  LocalRig(const LocalRig&) = delete;
  LocalRig& operator=(const LocalRig&) = delete;
  /// Closes the rig; then, without made_safe(), the guard acts.
  ~LocalRig();

  [[nodiscard]] hal::Rig& rig() noexcept { return *rig_; }

  /// Tells the guard that the device has confirmed the safe output. @throws DeviceError  the guard had died
  void made_safe();

 private:
  std::filesystem::path snapshot_folder_;
  std::optional<GuardProcess> guard_;
  std::unique_ptr<hal::Rig> rig_;  // after guard_: closed before the guard may act
};

}  // namespace eha::cli
