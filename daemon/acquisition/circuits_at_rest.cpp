// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/circuits_at_rest.hpp"

namespace eha::acquisition {
namespace {

constexpr std::chrono::duration<double> kDropsOut{0.5};  // a coil with a freewheeling diode takes 0.2 to 0.4 s

CircuitAtRest shown_by(const hal::RigReading& reading, bool has_dropped_out) noexcept {
  if (reading.emergency_stop) return CircuitAtRest::emergency_stop;
  return reading.enable_contact && has_dropped_out ? CircuitAtRest::contact : CircuitAtRest::sound;
}

}  // namespace

std::chrono::duration<double> longest_drop_out(const hal::RigCapabilities& rig) noexcept {
  return kDropsOut + std::chrono::duration<double>(rig.enable_contact_time_s);
}

CircuitAtRest circuit_at_rest(hal::Rig& rig, const hal::RigReading& reading,
                              std::chrono::duration<double> since_off) noexcept {
  const bool has_dropped_out = since_off > longest_drop_out(rig.capabilities());
  const CircuitAtRest shown = shown_by(reading, has_dropped_out);
  if (shown == CircuitAtRest::sound) return shown;
  hal::RigReading again;
  if (rig.read(0, again) != hal::RigStatus::ok) return CircuitAtRest::sound;
  return shown_by(again, has_dropped_out);
}

std::string_view sentence_of(CircuitAtRest circuit) noexcept {
  switch (circuit) {
    case CircuitAtRest::sound:
      return "";
    case CircuitAtRest::emergency_stop:
      return "the emergency-stop circuit was opened while nothing was driven";
    case CircuitAtRest::contact:
      return "the auxiliary contact of the enable contactor is closed although the enable line is off; the contactor "
             "may be welded: switch the hydraulics off by hand and check it";
  }
  return "";
}

}  // namespace eha::acquisition
