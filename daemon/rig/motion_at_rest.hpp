// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "hal/rig.hpp"

namespace eha {

/// Where an undriven rod was at a time.
struct RodAtRest {
  std::chrono::steady_clock::time_point at;
  double place_in = 0.0;
  double speed_in_per_s = 0.0;  ///< at the end of a run
};

/// A rod within this distance of the start of a rehearsal has not moved: the tolerance of a placing (eha-experiment(5),
/// [place]).
inline constexpr double kSamePlace_in = 0.02;

/// How far a rod whose hydraulics are off, and its reading, may have moved since a reading [in]: 0.1 in, which a rod
/// moves by hand only; the creep of a leaking cylinder, 0.03 in/s, where the reading is older than half a second, 0.1
/// in at most; and what the speed of then carries it in 0.25 s.
[[nodiscard]] inline double most_motion_at_rest(std::chrono::duration<double> since,
                                                double speed_in_per_s = 0.0) noexcept {
  constexpr double kMoves_in = 0.1;
  constexpr double kCreeps_in_per_s = 0.03;
  constexpr double kMostCreep_in = 0.1;
  constexpr double kShort_s = 0.5;
  constexpr double kCoasts_s = 0.25;
  const double coast_in = std::isfinite(speed_in_per_s) ? kCoasts_s * std::abs(speed_in_per_s) : 0.0;
  return kMoves_in + coast_in + std::clamp(kCreeps_in_per_s * (since.count() - kShort_s), 0.0, kMostCreep_in);
}

/// The reading of an undriven rod moved; nothing was driven.
class RodMoved : public DeviceError {
 public:
  using DeviceError::DeviceError;
};

/// Checks immediately before a rod is driven that its reading is where it was: files are made between the last reading
/// and the first tick. Interference in one reading is no motion.
/// @param unit  of lengths in the message
/// @throws RodMoved  it moved farther than most_motion_at_rest()
void require_at_rest(hal::Rig& rig, const RodAtRest& rest, const DisplayUnit& unit);

}  // namespace eha
