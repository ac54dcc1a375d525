// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace eha::cli {

/// The result of an experiment of the queue: "completed, accepted: io, fo", "faulted", ...
[[nodiscard]] std::string verdict_text(const nlohmann::ordered_json& entry);

/// When the experiments of a queue end by the clock, "15:44" in local time, one text an entry: of the one that is
/// played by the time in its run's name, of those that wait behind it one after the other, arming and fits left out.
/// Empty for others, in virtual time, and where nothing is played.
[[nodiscard]] std::vector<std::string> end_times(const nlohmann::ordered_json& entries);

/// What the service still does with the run of an experiment: "is being played", "is being fitted, for 5:10 min so far,
/// with 1 s of processor time ...", "waits for its fit"; empty once it is over, or before it is played.
[[nodiscard]] std::string progress_text(const nlohmann::ordered_json& entry);

/// The experiment of a run in the queue of a service; null where none answers there or knows the run.
/// @param run  a run's folder
[[nodiscard]] nlohmann::ordered_json entry_of_run(const std::filesystem::path& run,
                                                  const std::filesystem::path& socket);

/// A table of a queue: the experiments that are not over, and the last five that are; long results are cut.
[[nodiscard]] std::string queue_table(const nlohmann::ordered_json& entries);

}  // namespace eha::cli
