// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>

#include "config/experiment_config.hpp"
#include "daemon/acquisition/command_source.hpp"
#include "daemon/place/loop_monitor.hpp"
#include "daemon/track/reckoned_place.hpp"
#include "ident/control/trial.hpp"

namespace eha::track {

/// Returns the controller's first row: the first one after the pressure has risen.
[[nodiscard]] inline std::uint32_t first_tracked_row(const config::RigLimits& limits, double tick_s) {
  const double delay_s = limits.following ? limits.following->pressure_delay_s : 0.0;
  return 1 + static_cast<std::uint32_t>(std::ceil(delay_s / tick_s * (1.0 - 1e-12)));
}

/// Plays a controller's trial in closed loop, from the rod's present position. The first rows request the valve's null;
/// the controller starts without a bump. Ends the run if the rod follows worse, or the command swings more often, than
/// the controller's file allows. Checks loop_speed, no_motion and wrong_speed as in a placing, but with a command that
/// may change as fast as the slew limit, and wrong_place (ReckonedPlace). The command stays within closed_loop_most_V()
/// of the null. Range and slew limit of the rig are applied afterwards. Real-time safe. Not thread-safe. Cost: about
/// 0.3 us a tick.
class TrackSource final : public acquisition::CommandSource {
 public:
  /// @param limits  of the rig
  TrackSource(const config::Track& track, const config::RigLimits& limits);

  [[nodiscard]] std::uint32_t rows() const noexcept override {
    return first_row_ - 1 + static_cast<std::uint32_t>(motion_.rows());
  }
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
  std::uint32_t first_row_;
  place::LoopMonitor monitor_;
  ReckonedPlace reckoned_;
  double command_V_;  ///< of the tick before
  bool has_begun_ = false;
  acquisition::Breach breach_;
};

}  // namespace eha::track
