// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace eha::cli {

/// The result of an experiment of the queue: "completed, accepted: io, fo", "faulted", ...
[[nodiscard]] std::string verdict_text(const nlohmann::ordered_json& entry);

/// Predicts the end times of a queue's experiments, "15:44" in local time, one text an entry. The end of the one being
/// played follows from the time in its run's name; those that wait follow one after the other, without arming and fits.
/// Empty for others, in virtual time, and if no experiment is being played.
[[nodiscard]] std::vector<std::string> end_times(const nlohmann::ordered_json& entries);

/// Describes the service's present work on the run of an experiment: "is being played", "is being fitted, for 5:10 min
/// so far, with 1 s of processor time ...", "waits for its fit"; empty once it is over, or before it is played.
[[nodiscard]] std::string progress_text(const nlohmann::ordered_json& entry);

/// Finds the experiment of a run in the queue of a service; null if no service answers or it does not know the run.
/// @param run  a run's folder
[[nodiscard]] nlohmann::ordered_json entry_of_run(const std::filesystem::path& run,
                                                  const std::filesystem::path& socket);

/// What an experiment waits for, and why; empty: no reason is known.
struct Wait {
  std::string command;
  std::string why;
};

/// The parts of the member `waits_for` of ehad-protocol(7): "eha arm, then eha queue release 5: the rig was disarmed".
[[nodiscard]] Wait wait_of(const std::string& waits_for);

/// Writes a table of a queue, 100 columns wide: the unfinished experiments, a ">" before the one that is played, and
/// the last five finished ones. Cuts long results; `eha runs show RUN` has all of them. Below it, whole, why
/// experiments are held.
[[nodiscard]] std::string queue_table(const nlohmann::ordered_json& entries);

}  // namespace eha::cli
