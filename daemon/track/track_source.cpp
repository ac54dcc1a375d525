// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/track/track_source.hpp"

#include <cmath>

namespace eha::track {

using acquisition::Fault;

TrackSource::TrackSource(const config::Track& track, const config::RigLimits& limits)
    : plan_(track.plan),
      coefficients_(ident::coefficients(track.controller.settings)),
      controller_(coefficients_),
      motion_(coefficients_.settings, plan_, plan_.lowest),
      swings_(coefficients_.settings.inverse.null, track.controller.fault.swing_V, coefficients_.settings.tick_s),
      fault_(track.controller.fault),
      monitor_(place::loop_bounds(limits, coefficients_.settings.reference.velocity), coefficients_.settings.tick_s) {}

double TrackSource::voltage_V(std::uint32_t row, const hal::RigReading& last) noexcept {
  const double null_V = coefficients_.settings.inverse.null;
  if (row == 0) return null_V;
  if (!has_begun_) {
    has_begun_ = true;
    motion_ = ident::TrialMotion(coefficients_.settings, plan_, last.displacement_in);
    controller_.start(last.displacement_in, null_V);
  }
  const ident::AxisOutput out = controller_.step(motion_.set_point(row), last.displacement_in);
  monitor_.note(out.command, false, last);
  const int swings = swings_.step(out.command);
  if (breach_.fault == Fault::none) {
    const double error_in = std::abs(out.reference - last.displacement_in);
    if (error_in > fault_.following_error_in) {
      breach_ = {Fault::following_error, error_in, fault_.following_error_in};
    } else if (swings > fault_.swings_per_s) {
      breach_ = {Fault::oscillation, static_cast<double>(swings), fault_.swings_per_s};
    }
  }
  return out.command;
}

acquisition::Breach TrackSource::breach() const noexcept {
  return breach_.fault != Fault::none ? breach_ : monitor_.breach();
}

}  // namespace eha::track
