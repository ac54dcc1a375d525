// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/shell_word.hpp"

namespace eha::cli {

class Console;
struct RunCommand;

/// A command to the service that the user has just spoken to: --socket is added unless it is the default one.
[[nodiscard]] std::string through(const std::filesystem::path& socket, std::string command);

/// `eha run EXPERIMENT` with the options of a run that has just been made (--yes excepted: it is asked again).
[[nodiscard]] std::string again(const RunCommand& run, const std::string& experiment);

/// `eha run EXPERIMENT --local --fast`, on this rig file.
[[nodiscard]] std::string simulated_run(const std::string& experiment, const std::optional<std::string>& rig_file);

/// What opens the report of a run; `otherwise` where it has none.
[[nodiscard]] std::string report_of_run(const std::filesystem::path& folder, const std::string& otherwise);

/// `eha fit RUN`, with --discard 0 where the record ends in the discarded time; nothing for a record that is too short
/// to fit, or holds nothing to fit. Reads the record.
[[nodiscard]] std::optional<std::string> fit_of_run(const std::filesystem::path& folder);

/// "the partial record is in RUN; `eha fit RUN` fits it", or why not.
[[nodiscard]] std::string partial_record_text(const std::filesystem::path& folder);

/// The model file that a run recommends; nothing where it recommends none. @param folder  a run's
[[nodiscard]] std::optional<std::filesystem::path> recommended_model(const std::filesystem::path& folder);

/// `eha tune RUN`, with the newest valve sheet of the same rig beside that run; nothing where the run recommends no
/// model.
/// @param rig_file  as named for the run; none: the default
[[nodiscard]] std::optional<std::string> tune_of_run(const std::filesystem::path& folder,
                                                     const std::optional<std::string>& rig_file = {});

/// Warns where a run's recommended model has another valve than [following] of the rig file that the run was played by.
void warn_of_changed_valve(const std::filesystem::path& folder, const Console& console);

/// `eha tune MODEL` with the same sheet, for a model of that run's record.
[[nodiscard]] std::string tune_of_model(const std::filesystem::path& model, const std::filesystem::path& run);

}  // namespace eha::cli
