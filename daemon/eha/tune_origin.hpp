// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "config/rig_config.hpp"
#include "ident/model/model.hpp"
#include "ident/valve/leak.hpp"

// Where the model of a controller is from: its run, the rig of that run as it was and as it is now, its record.

namespace eha::cli {

class Console;
struct TuneCommand;

/// Returns the run that the model is from; none if it is of a file.
[[nodiscard]] std::optional<std::filesystem::path> run_of(const TuneCommand& command, const ident::Model& model);

/// The leak of the rig, by the valve sheet that is named, else by the newest one beside the model's run.
[[nodiscard]] std::optional<ident::Leak> leak_of(const TuneCommand& command, const ident::Model& model);

/// Finds the rig file: the named one, or that of the run which the model is from: the file itself as it is now, else
/// the default one, where that is of the same rig. Limits and [following] may have changed since, and the loop runs
/// with them as they are now.
[[nodiscard]] std::filesystem::path rig_path(const TuneCommand& command, const ident::Model& model,
                                             const Console& console);

/// The record of a model as a controller's file names it, so that it is found from any folder.
[[nodiscard]] std::string named_record(const std::map<std::string, std::string>& provenance);

/// Says that the rig file in force has another valve, or another simulated plant, than when the model's run was played.
/// Empty: not known to.
[[nodiscard]] std::string changed_since_run(const TuneCommand& command, const ident::Model& model);

/// Why nothing shows that a model is of a rig: its record is of no run, or of a run of another rig. Empty: it is shown.
[[nodiscard]] std::string why_not_of(const TuneCommand& command, const ident::Model& model,
                                     const config::RigConfig& rig);

}  // namespace eha::cli
