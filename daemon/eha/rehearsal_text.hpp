// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "daemon/eha/console.hpp"
#include "daemon/rehearsal/rehearsal.hpp"

namespace eha::cli {

/// Where the rod of a rig is taken to be before it has been read: a simulated one where it begins, otherwise
/// mid-travel [in].
[[nodiscard]] double start_of(const config::RigConfig& rig);

[[nodiscard]] nlohmann::ordered_json to_json(const Rehearsal& rehearsal);

/// What an experiment will do to the rod: "rehearsed with the rig's valve: the rod stays within ...".
[[nodiscard]] std::string sentence_on(const Rehearsal& rehearsal, const Console& console);

/// Warns where one draw in twenty reaches a limit; nothing where it could not be rehearsed.
void warn_of_trips(const std::optional<Rehearsal>& rehearsal, const std::string& experiment_file,
                   const Console& console);

/// Both as messages, before a run.
void report_rehearsal(const std::optional<Rehearsal>& rehearsal, const std::string& experiment_file,
                      const Console& console);

/// Says of a run that reached a limit what drifted and which offset stops it, from the files in its folder; nothing
/// where they do not tell.
void explain_trip(const std::string& run_folder, const Console& console);

}  // namespace eha::cli
