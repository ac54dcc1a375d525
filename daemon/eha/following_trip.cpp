// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/following_trip.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "daemon/acquisition/following_monitor.hpp"
#include "daemon/acquisition/run_report.hpp"
#include "daemon/acquisition/tick_record.hpp"

namespace eha::cli {

std::string way_out_of_following(std::string_view fault, const std::string& rig_file) {
  using acquisition::Fault;
  constexpr std::array kOfFollowing{Fault::no_motion,      Fault::not_in_place,  Fault::loop_speed,
                                    Fault::wrong_speed,    Fault::not_following, Fault::unexplained_motion,
                                    Fault::velocity_limit, Fault::travel_limit};
  if (fault.find(acquisition::kReadingJumps) != std::string_view::npos) return {};
  const std::string_view name = fault.substr(0, fault.find(' '));
  const auto* cause = std::find_if(kOfFollowing.begin(), kOfFollowing.end(),
                                   [&](Fault one) { return acquisition::to_text(one) == name; });
  if (cause == kOfFollowing.end()) return {};
  return fmt::format(
      "a wrong [following] of {} can cause this. If rod, sensor and hydraulics are sound, or if it was never measured "
      "here: comment the table out for this run, which measures the valve without it (where ehad runs: eha disarm, eha "
      "reload, eha arm)",
      rig_file);
}

std::string way_out_without_following(std::string_view fault) {
  if (!fault.starts_with(acquisition::to_text(acquisition::Fault::not_following))) return {};
  return fmt::format(
      "without [following] volts more than {:g} V from 0 must move the rod. If rod, sensor and hydraulics are sound, "
      "null or dead band of this valve reach farther: write estimates of them into [following] (see FOLLOWING in "
      "eha-rig(5)), then measure again",
      acquisition::kFallbackDeadBand_V);
}

}  // namespace eha::cli
