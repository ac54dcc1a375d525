// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

#include "config/experiment_config.hpp"

namespace eha::acquisition {

/// A PID with all that a tick of a controller can have, on a rod of 1 in/(V s), between two places.
/// @param from_in, to_in  @param duration_s  of the way there and back
inline config::Track tracked(double from_in, double to_in, double duration_s) {
  config::Track track;
  ident::AxisSettings& s = track.controller.settings;
  s.kind = ident::FeedbackKind::pid;
  s.feedback = {.kp = 2.0, .ki = 0.5, .kd = 0.01, .filter_s = 0.01};
  s.rest_error = 1e-4;
  s.tracking_s = 4.0;
  s.most_speed = 1.0;
  s.inverse = {.null = 0.0, .dead_band = 0.05, .gain_positive = 1.0, .gain_negative = 1.0, .smoothing = 0.05};
  s.reference = {.lowest = 0.0, .highest = 5.9, .velocity = 0.5, .acceleration = 2.0, .jerk = 40.0};
  s.command_min = -1.5;
  s.command_max = 1.5;
  s.slew_per_s = 20.0;
  track.controller.fault = {.following_error_in = 1.0, .swing_V = 0.5, .swings_per_s = 100.0};
  track.plan = ident::trial_plan(s);
  track.plan.reference = {{0.0, from_in}, {0.5 * duration_s, to_in}, {duration_s, from_in}};
  return track;
}

}  // namespace eha::acquisition
