// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/motion_at_rest.hpp"

#include <fmt/format.h>

#include <optional>

namespace eha {

void require_at_rest(hal::Rig& rig, const RodAtRest& rest, const DisplayUnit& unit) {
  constexpr int kReadings = 3;
  std::optional<double> moved_in;
  for (int attempt = 0; attempt < kReadings; ++attempt) {
    hal::RigReading reading;
    if (rig.read(0, reading) != hal::RigStatus::ok) continue;
    moved_in = reading.displacement_in - rest.place_in;
    const auto since = std::chrono::steady_clock::now() - rest.at;
    if (!(std::abs(*moved_in) > most_motion_at_rest(since, rest.speed_in_per_s))) return;
  }
  if (!moved_in) return;  // the loop judges a card that cannot be read
  throw RodMoved(
      fmt::format("the rod's reading moved by {:.2g} {} while nothing drove it: nothing is driven; "
                  "look at the rod, its contactor, the sensor and its wire",
                  unit.factor("in") * *moved_in, unit.of("in")));
}

}  // namespace eha
