// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/shell_word.hpp"
#include "ident/validation/first_step.hpp"

namespace eha::cli {

struct RunCommand;

/// Adds --socket to a command for the service that the user has just used, unless it is the default one.
[[nodiscard]] std::string through(const std::filesystem::path& socket, std::string command);

/// The commands that put a new rig file, once it is checked, in the place of a service's and have it read.
[[nodiscard]] std::string put_in_force(const std::filesystem::path& made, const std::filesystem::path& of_service,
                                       const std::filesystem::path& socket);

/// `eha run EXPERIMENT` with the options of the last run, except --yes: the user is asked again.
[[nodiscard]] std::string again(const RunCommand& run, const std::string& experiment);
[[nodiscard]] std::string again(const RunCommand& run, const std::vector<std::string>& experiments);

/// `eha run EXPERIMENT --local --fast`, on this rig file.
[[nodiscard]] std::string simulated_run(const std::string& experiment, const std::optional<std::string>& rig_file);

/// Returns a file's name that is not taken in the present folder: "rig-new.toml", else "rig-new-2.toml", ...
[[nodiscard]] std::string free_name(const std::string& name);

/// `eha characterise [RUN] -o rig-new.toml`, with a name that is not taken. @param run  empty: a new measurement
[[nodiscard]] std::string characterise_anew(const std::string& run = {});

/// Returns the command that opens the report of a run; `otherwise` if it has none.
[[nodiscard]] std::string report_of_run(const std::filesystem::path& folder, const std::string& otherwise);

/// Returns the command that looks for the cause of a placing's trip on a local rig: `eha read`, which shows whether the
/// sensor follows the rod. A simulated rig has sound hydraulics, valve and wires: if its rod does not move as
/// [following] says, `eha characterise`, which measures that.
/// @param fault  its name, such as "no_motion"
[[nodiscard]] std::string next_after_trip(std::string_view fault, bool moves_machine);

/// `eha fit RUN`, with --discard 0 if the record ends within the discarded time; nothing for a record that is too short
/// to fit, or has no rows to fit. Reads the record.
[[nodiscard]] std::optional<std::string> fit_of_run(const std::filesystem::path& folder);

/// Whether a run has a row that can be read. False for a folder that this user may not read.
[[nodiscard]] bool has_rows(const std::filesystem::path& folder);

/// `eha run EXPERIMENT` as the run in the folder was played: --local, --fast and --rig for one of a simulated rig in
/// this user's own process, as far as run.json says.
/// @param asked_service  whether a service has the run
[[nodiscard]] std::string again_as_run(const std::filesystem::path& folder, const std::string& experiment,
                                       bool asked_service);

/// "the partial record is in RUN; `eha fit RUN` fits it", or the reason why it cannot be fitted.
[[nodiscard]] std::string partial_record_text(const std::filesystem::path& folder);

/// The same for a run with nothing to fit, a placing or a characterisation: `eha plot RUN` shows it.
[[nodiscard]] std::string kept_record_text(const std::filesystem::path& folder);

/// Returns the file of a run's recommended model; nothing if it recommends none. @param folder  a run's
[[nodiscard]] std::optional<std::filesystem::path> recommended_model(const std::filesystem::path& folder);

/// What ident::next_step() names first of a run's models; none where the caller may not read them.
[[nodiscard]] ident::NextStep first_of_run(const std::filesystem::path& folder);

/// `eha fit RUN --to 38.64`, the part of a run that ident::next_step() keeps; none where it cuts nothing.
[[nodiscard]] std::optional<std::string> cut_of_run(const std::filesystem::path& folder);

/// `eha tune RUN`, with the newest valve sheet of the same rig beside that run; nothing if the run recommends no model.
/// @param rig_file  as named for the run; none: the default
[[nodiscard]] std::optional<std::string> tune_of_run(const std::filesystem::path& folder,
                                                     const std::optional<std::string>& rig_file = {});

/// `eha tune MODEL` with the same sheet, for a model of that run's record.
[[nodiscard]] std::string tune_of_model(const std::filesystem::path& model, const std::filesystem::path& run);

}  // namespace eha::cli
