// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/track/track_source.hpp"

#include <cmath>
#include <limits>

#include "config/valve_estimate.hpp"

namespace eha::track {

using acquisition::Fault;

namespace {

/// Limits of a placing, except for the growth of the command: a reference may change it as fast as the slew limit
/// allows.
place::LoopBounds bounds_of(const config::RigLimits& limits, const ident::AxisSettings& settings) {
  place::LoopBounds bounds = place::loop_bounds(limits, settings.reference.velocity);
  bounds.most_V = config::closed_loop_most_V(limits);
  bounds.growth_V_per_s = std::numeric_limits<double>::infinity();
  bounds.compares_slope = true;
  if (!limits.following) bounds.null_V = settings.inverse.null;
  return bounds;
}

}  // namespace

TrackSource::TrackSource(const config::Track& track, const config::RigLimits& limits)
    : plan_(track.plan),
      coefficients_(ident::coefficients(track.controller.settings)),
      controller_(coefficients_),
      motion_(coefficients_.settings, plan_, plan_.lowest),
      swings_(coefficients_.settings.inverse.null, track.controller.fault.swing_V, coefficients_.settings.tick_s),
      fault_(track.controller.fault),
      first_row_(first_tracked_row(limits, coefficients_.settings.tick_s)),
      monitor_(bounds_of(limits, coefficients_.settings), coefficients_.settings.tick_s),
      reckoned_(limits, coefficients_.settings.tick_s),
      command_V_(coefficients_.settings.inverse.null) {}

double TrackSource::voltage_V(std::uint32_t row, const hal::RigReading& last) noexcept {
  const double null_V = coefficients_.settings.inverse.null;
  if (row < first_row_) return row == 0 ? null_V : monitor_.bounded_V(null_V, last);
  if (!has_begun_) {
    has_begun_ = true;
    motion_ = ident::TrialMotion(coefficients_.settings, plan_, last.displacement_in);
    controller_.start(last.displacement_in, null_V);
  }
  const std::size_t tick = row - first_row_ + 1;
  const ident::AxisOutput out =
      controller_.step(motion_.set_point(tick), last.displacement_in - motion_.injected(tick));
  reckoned_.note(last.displacement_in, command_V_);
  const double command_V = monitor_.bounded_V(out.command, last);
  command_V_ = command_V;
  const int swings = swings_.step(command_V);
  if (breach_.fault == Fault::none) {
    const double error_in = std::abs(out.reference - last.displacement_in);
    if (error_in > fault_.following_error_in) {
      breach_ = {Fault::following_error, error_in, fault_.following_error_in};
    } else if (swings > fault_.swings_per_s) {
      breach_ = {Fault::oscillation, static_cast<double>(swings), fault_.swings_per_s};
    } else {
      breach_ = reckoned_.breach();
    }
  }
  return command_V;
}

acquisition::Breach TrackSource::breach() const noexcept {
  return breach_.fault != Fault::none ? breach_ : monitor_.breach();
}

}  // namespace eha::track
