// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "config/rig_config.hpp"
#include "config/valve_estimate.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/suggest/commands.hpp"
#include "daemon/tune/following_agreement.hpp"
#include "ident/model/model.hpp"

namespace eha::cli {

/// A valve as measured or fitted.
struct FoundValve {
  tune::FoundMap map = {};
  std::optional<std::pair<double, double>> gains = {};  ///< extending and retracting, of a sheet [in/(V s)]
  std::string source = {};                              ///< "the valve sheet of RUN"
  std::string remedy = {};                              ///< command that brings the rig file up to date
  std::string note = {};                                ///< ident::map_note() of a model
};

/// Returns the valve of a run's sheet, with the command that writes its numbers into a rig file.
/// @param run  a run of [characterise]   @param rig  for the name of that file
[[nodiscard]] std::optional<FoundValve> valve_of_sheet(const std::filesystem::path& run,
                                                       const suggest::RigAccess& rig = {});

/// Whether null and dead band of a model with a map are those of a sheet's valve, given what the two may differ by.
[[nodiscard]] bool is_of_one_valve(const ident::Model& model, const FoundValve& sheet);

/// Returns the valve of a model with a map. The remedy is that of a sheet that agrees with it, otherwise a new
/// measurement. @param name  of the model, in a sentence
[[nodiscard]] FoundValve valve_of_model(const ident::Model& model, const std::string& name,
                                        const std::optional<FoundValve>& sheet, const suggest::RigAccess& rig);

/// Warns if null, dead band or a gain of [following] in a rig file are not those of a found valve. Says it where the
/// error of the model's map alone makes the difference, and where that error is worth knowing beside values that agree.
/// @returns whether it warned of another valve
bool warn_if_following_differs(const config::RigConfig& rig, const FoundValve& found, const Console& console);

/// Warns of the leak that the newest valve sheet beside a run shows. @returns whether there is one
bool warn_of_leak(const std::filesystem::path& run, const Console& console, const std::string& units);

/// Says what the error of the map of a model means, with the model's name; nothing where the map fits, or where the
/// newest valve sheet beside the run has the same null and dead band.
/// @param run  of its record; empty: it is of none
void say_map_note(const ident::Model& model, const std::filesystem::path& run, const Console& console);

/// The same for a run's rig file and the newest valve sheet beside the run.
/// @returns the command that writes the rig file with the sheet's numbers, where it warned
std::optional<std::string> warn_of_unused_sheet(const std::filesystem::path& run, const Console& console);

/// What a run says of its valve beside rig file and valve sheet.
enum class ValveNow {
  as_known,
  /// Since the rig file was measured, and no newer valve sheet agrees with the run; or the run's map is too far off to
  /// say, and no sheet lies beside it.
  changed,
  leaks,  ///< by the newest valve sheet
};

/// The same for a run's rig file and the model that the run recommends, after say_map_note() of it. Names a gain that
/// is another one, too, and of a rig that leaks the leak alone.
[[nodiscard]] ValveNow warn_of_changed_valve(const std::filesystem::path& run, const Console& console);

}  // namespace eha::cli
