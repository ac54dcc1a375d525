// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/ruler_check.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"
#include "daemon/acquisition/slip_limit.hpp"
#include "hal/backends/backend.hpp"

namespace eha {
namespace {

/// Greatest difference of the sensor from the ruler [in].
constexpr double kRulerTolerance_in = 0.1;

}  // namespace

bool needs_ruler(const config::RigConfig& rig) { return !rig.limits.following && hal::moves_machine(rig.backend); }

void require_agreement_with_ruler(std::optional<double> ruler_in, double shown_in, const DisplayUnit& unit) {
  if (!ruler_in) {
    throw UsageError(
        "the rig file has no [following], so that nothing shows a wrong calibration of the sensor before the rod "
        "moves: read its position off a ruler and add --ruler LENGTH, or calibrate first (`eha calibrate`)");
  }
  if (!(std::abs(*ruler_in - shown_in) <= kRulerTolerance_in)) {
    const double factor = unit.factor("in");
    throw ConfigError(fmt::format(
        "the sensor shows the rod at {0:.3f} {3}, the ruler at {1:.3f} {3}; they may differ by {2:.3g} {3}: "
        "calibrate the sensor (`eha calibrate`) before the rod moves",
        factor * shown_in, factor * *ruler_in, factor * kRulerTolerance_in, unit.of("in")));
  }
}

void require_place_by_ruler(double ruler_in, double shown_in, const DisplayUnit& unit) {
  if (std::abs(ruler_in - shown_in) <= acquisition::kMostSlip_in) return;
  const double factor = unit.factor("in");
  throw ConfigError(
      fmt::format("not armed: the sensor shows the rod at {0:.3f} {3}, the ruler at {1:.3f} {3}; they may differ by "
                  "{2:.3g} {3}: `eha calibrate --sensor-moved` with the ruler at three places or more, and its Next",
                  factor * shown_in, factor * ruler_in, factor * acquisition::kMostSlip_in, unit.of("in")));
}

}  // namespace eha
