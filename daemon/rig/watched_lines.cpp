// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/watched_lines.hpp"

#include <chrono>
#include <future>
#include <string>

#include "core/error.hpp"
#include "daemon/acquisition/circuits_at_rest.hpp"

namespace eha {

void with_watched_lines(hal::Rig& rig, const std::function<void()>& work) {
  using acquisition::CircuitAtRest;
  constexpr std::chrono::milliseconds kInterval{20};
  // The contact, which may still be closed, was looked at when the card was opened.
  constexpr std::chrono::seconds kContactIsNotJudged{0};
  std::future<void> done = std::async(std::launch::async, work);
  bool was_opened = false;
  do {
    hal::RigReading reading;
    if (rig.read(0, reading) != hal::RigStatus::ok) continue;
    was_opened =
        was_opened || acquisition::circuit_at_rest(rig, reading, kContactIsNotJudged) == CircuitAtRest::emergency_stop;
  } while (done.wait_for(kInterval) != std::future_status::ready);
  done.get();
  if (was_opened) {
    throw DeviceError(std::string(acquisition::sentence_of(CircuitAtRest::emergency_stop)) +
                      ": nothing is driven; give the command again once nobody is at the rod");
  }
}

}  // namespace eha
