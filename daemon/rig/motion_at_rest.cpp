// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/motion_at_rest.hpp"

#include <fmt/format.h>

#include "core/error.hpp"

namespace eha {

void require_at_rest(hal::Rig& rig, const RodAtRest& rest, const DisplayUnit& unit) {
  double moved_in = 0.0;
  for (int attempt = 0; attempt < 2; ++attempt) {
    hal::RigReading reading;
    // The loop judges a card that cannot be read.
    if (rig.read(0, reading) != hal::RigStatus::ok) return;
    moved_in = reading.displacement_in - rest.place_in;
    const auto since = std::chrono::steady_clock::now() - rest.at;
    if (!(std::abs(moved_in) > most_motion_at_rest(since, rest.speed_in_per_s))) return;
  }
  throw DeviceError(
      fmt::format("the rod's reading moved by {:.2g} {} with the hydraulics off, just before the run: nothing is "
                  "driven; look at the "
                  "rod, its contactor, the sensor and its wire",
                  unit.factor("in") * moved_in, unit.of("in")));
}

}  // namespace eha
