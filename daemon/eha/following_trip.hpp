// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "daemon/acquisition/run_report.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/suggest/commands.hpp"

namespace eha::cli {

/// What ended a run, as far as it says whether a wrong [following] can be the cause.
struct Trip {
  std::string fault = {};      ///< its name, such as "no_motion"; empty: none
  bool reading_jumps = false;  ///< the readings moved as no rod does, which no [following] makes
  bool stands_still = false;   ///< no_motion of a rod that stood, as without pressure
};
[[nodiscard]] Trip trip_of(const acquisition::FaultReport& fault);
[[nodiscard]] Trip trip_of(const record::Manifest& manifest);
/// The same of a run's folder; no fault where the caller may not read it.
[[nodiscard]] Trip trip_of_run(const std::filesystem::path& folder);

/// Whether a wrong [following] can cause it.
[[nodiscard]] bool may_be_of_following(const Trip& trip);

/// Whether that is looked at first: a rod that does not move has more often no pressure, or a valve without its plug.
[[nodiscard]] bool is_first_of_following(const Trip& trip);

/// Says how to measure the valve of a rig whose characterisation was ended by a fault that a wrong [following] can
/// cause; empty for another fault.
[[nodiscard]] std::string way_out_of_following(const Trip& trip, const std::string& rig_file,
                                               const suggest::RigAccess& rig);

/// The same of a rig file without [following], where the valve's edges may lie beyond what its rules allow, and the
/// lines to write into the file.
struct WayOut {
  std::string sentence;  ///< empty for another fault
  std::string lines;
};
[[nodiscard]] WayOut way_out_without_following(const Trip& trip, const std::string& rig_file);

/// The description of the end of a characterisation without the causes in [following] that the rig file has not.
[[nodiscard]] std::string without_causes_of_following(std::string description);

}  // namespace eha::cli
