// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "config/rig_config.hpp"
#include "daemon/eha-safe/guard_process.hpp"
#include "hal/rig.hpp"

namespace eha {

/// A rig opened in this process. A card gets a guard first: a process that makes it safe should this one be killed.
/// Not thread-safe.
class OwnedRig {
 public:
  /// @param snapshot  where what makes the card safe is written for eha-safe, and left; empty: in a private file that
  ///                  goes with this object
  /// @throws DeviceError, PermissionError, ConfigError as hal::open_comedi, hal::open_sim, GuardProcess
  explicit OwnedRig(const config::RigConfig& config, std::filesystem::path snapshot = {});
  OwnedRig(const OwnedRig&) = delete;
  OwnedRig& operator=(const OwnedRig&) = delete;
  /// Closes the rig; then, without made_safe(), the guard acts.
  ~OwnedRig();

  [[nodiscard]] hal::Rig& rig() noexcept { return *rig_; }

  /// Whether nobody would make the card safe should this process be killed: its guard has died. Never on a simulated
  /// rig.
  [[nodiscard]] bool is_unguarded() const noexcept { return guard_ && !guard_->watches(); }

  /// Tells the guard that the device has confirmed the safe output, once nothing more will be driven.
  /// @throws DeviceError  the guard had died
  void made_safe();

 private:
  std::filesystem::path private_folder_;
  std::optional<GuardProcess> guard_;
  std::unique_ptr<hal::Rig> rig_;  // after guard_: closed before the guard may act
};

}  // namespace eha
