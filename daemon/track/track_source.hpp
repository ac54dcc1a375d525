// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/experiment_config.hpp"
#include "daemon/acquisition/command_source.hpp"
#include "daemon/place/loop_monitor.hpp"
#include "ident/control/trial.hpp"

namespace eha::track {

/// Plays a controller's trial in closed loop, from where the rod stands. Row 0 asks for the valve's null; the
/// controller begins in row 1, without a bump. Ends the run where the rod follows worse, or the command swings more
/// often, than the controller's file allows; loop_speed and wrong_speed as in a placing. Range and slew of the rig come
/// after it. Real-time safe. Not thread-safe. Cost: about 0.3 us a tick.
class TrackSource final : public acquisition::CommandSource {
 public:
  /// @param limits  of the rig
  TrackSource(const config::Track& track, const config::RigLimits& limits);

  [[nodiscard]] std::uint32_t rows() const noexcept override { return static_cast<std::uint32_t>(motion_.rows()); }
  [[nodiscard]] std::uint32_t rows_per_repetition() const noexcept override { return rows(); }
  [[nodiscard]] double voltage_V(std::uint32_t row, const hal::RigReading& last) noexcept override;
  [[nodiscard]] acquisition::Breach breach() const noexcept override;

 private:
  ident::TrialPlan plan_;
  ident::AxisCoefficients coefficients_;
  ident::AxisController controller_;
  ident::TrialMotion motion_;
  ident::SwingCounter swings_;
  config::ControllerFaults fault_;
  place::LoopMonitor monitor_;
  bool has_begun_ = false;
  acquisition::Breach breach_;
};

}  // namespace eha::track
