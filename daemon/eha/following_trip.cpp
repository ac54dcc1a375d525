// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/following_trip.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "daemon/acquisition/following_monitor.hpp"
#include "daemon/acquisition/run_report.hpp"
#include "daemon/acquisition/tick_record.hpp"
#include "daemon/eha/next_command.hpp"

namespace eha::cli {

bool may_be_of_following(std::string_view fault) {
  using acquisition::Fault;
  constexpr std::array kOfFollowing{Fault::no_motion,      Fault::not_in_place,  Fault::loop_speed,
                                    Fault::wrong_speed,    Fault::not_following, Fault::unexplained_motion,
                                    Fault::velocity_limit, Fault::travel_limit};
  if (fault.find(acquisition::kReadingJumps) != std::string_view::npos) return false;
  const std::string_view name = fault.substr(0, fault.find(' '));
  return std::any_of(kOfFollowing.begin(), kOfFollowing.end(),
                     [&](Fault one) { return acquisition::to_text(one) == name; });
}

std::string way_out_of_following(std::string_view fault, const std::string& rig_file, const suggest::RigAccess& rig) {
  if (!may_be_of_following(fault)) return {};
  return fmt::format(
      "a wrong [following] of {} can cause this. If rod, sensor and hydraulics are sound, or if it was never measured "
      "here: `{}` writes a copy without it, moves nothing, and its Next measures the valve with that",
      rig_file, suggest::without_following(rig));
}

WayOut way_out_without_following(std::string_view fault, const std::string& rig_file) {
  using acquisition::Fault;
  const std::string_view name = fault.substr(0, fault.find(' '));
  if (name != acquisition::to_text(Fault::not_following) && name != acquisition::to_text(Fault::no_motion)) return {};
  return {
      fmt::format(
          "{} has no [following]: volts more than {:g} V from 0 must then move the rod, and where an edge of the dead "
          "band lies farther, or its middle far from safe_V, the search for it gives up. If rod, sensor and "
          "hydraulics are sound, write estimates, from the valve's data sheet say, into {} as below (where ehad "
          "runs: eha disarm, eha reload, eha arm), then measure again, which replaces them",
          rig_file, acquisition::kFallbackDeadBand_V, rig_file),
      "For the rig file, with the valve's own numbers:\n\n"
      "[following]\n"
      "gain_positive_in_per_V_s = ?     # half of speed over volts outside the\n"
      "gain_negative_in_per_V_s = ?     # dead band, extending and retracting\n"
      "null_V = ?                       # middle of the dead band\n"
      "dead_band_V = ?                  # half of it, and 0.05 V more\n"};
}

std::string without_causes_of_following(std::string description) {
  if (const auto at = description.find(acquisition::kWrongNull); at != std::string::npos) {
    description.erase(at, acquisition::kWrongNull.size());
  }
  return description;
}

}  // namespace eha::cli
