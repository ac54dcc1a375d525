// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/following_trip.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.hpp"
#include "daemon/acquisition/following_monitor.hpp"
#include "daemon/acquisition/run_report.hpp"
#include "daemon/acquisition/tick_record.hpp"
#include "daemon/eha/next_command.hpp"

namespace eha::cli {

namespace {

/// Of a no_motion: that the rod did not move at all. With a wrong null it does, however little. @param moved_in  [in]
bool is_still(double moved_in) {
  constexpr double kNothing_in = 0.001;
  return !(std::abs(moved_in) > kNothing_in);
}

}  // namespace

Trip trip_of(const acquisition::FaultReport& fault) {
  using acquisition::Fault;
  // Near enough to its place, and yet not at rest.
  const bool scatters = fault.fault == Fault::not_in_place && fault.value < fault.limit;
  return {fault.fault == Fault::none ? std::string() : std::string(acquisition::to_text(fault.fault)),
          scatters || acquisition::reading_jumped(fault), fault.fault == Fault::no_motion && is_still(fault.value)};
}

Trip trip_of(const record::Manifest& manifest) {
  using acquisition::Fault;
  const nlohmann::ordered_json fault = record::fault_of(manifest);
  if (fault.is_null()) return {};
  Trip trip{fault.at("cause").get<std::string>(), record::reading_jumped(manifest)};
  const auto number = [&](const char* key) {
    return fault.contains(key) && fault.at(key).is_number() ? fault.at(key).get<double>() : std::nan("");
  };
  if (trip.fault == acquisition::to_text(Fault::not_in_place) && number("value") < number("limit")) {
    trip.reading_jumps = true;
  }
  trip.stands_still = trip.fault == acquisition::to_text(Fault::no_motion) && is_still(number("value"));
  return trip;
}

Trip trip_of_run(const std::filesystem::path& folder) {
  try {
    return trip_of(record::read_manifest(folder));
  } catch (const Error&) {
    return {};
  }
}

bool may_be_of_following(const Trip& trip) {
  using acquisition::Fault;
  constexpr std::array kOfFollowing{Fault::no_motion,      Fault::not_in_place,  Fault::loop_speed,
                                    Fault::wrong_speed,    Fault::not_following, Fault::unexplained_motion,
                                    Fault::velocity_limit, Fault::travel_limit};
  return !trip.reading_jumps && std::any_of(kOfFollowing.begin(), kOfFollowing.end(),
                                            [&](Fault one) { return acquisition::to_text(one) == trip.fault; });
}

bool is_first_of_following(const Trip& trip) { return may_be_of_following(trip) && !trip.stands_still; }

std::string way_out_of_following(const Trip& trip, const std::string& rig_file, const suggest::RigAccess& rig) {
  if (!may_be_of_following(trip)) return {};
  return fmt::format(
      "a wrong [following] of {} can cause this. If rod, sensor and hydraulics are sound, or if it was never measured "
      "here: `{}` writes a copy without it, moves nothing, and its Next measures the valve with that",
      rig_file, suggest::without_following(rig));
}

WayOut way_out_without_following(const Trip& trip, const std::string& rig_file) {
  using acquisition::Fault;
  const bool is_known =
      trip.fault == acquisition::to_text(Fault::not_following) || trip.fault == acquisition::to_text(Fault::no_motion);
  if (!is_known) return {};
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
