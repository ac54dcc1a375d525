// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/eha/fit_command.hpp"
#include "daemon/identify/identification.hpp"
#include "daemon/identify/source.hpp"

// The commands that go on after a fit.

namespace eha::cli {

/// A model of another record in a folder.
struct OtherModel {
  std::string file;
  std::string record;
};

[[nodiscard]] std::optional<OtherModel> model_of_other_record(const std::filesystem::path& folder,
                                                              const identify::Source& source);

/// The command as suggestions repeat it: with -o of a folder that is not there yet, so that no models are overwritten.
[[nodiscard]] FitCommand into_new_folder(FitCommand command);

/// The command that fits the part of the record that ident::next_step() keeps; none of a record that is cut already.
[[nodiscard]] std::optional<std::string> cut_command(const FitCommand& command, const identify::Source& source,
                                                     const identify::Identification& identification);

/// The fit of a record whose input column is mended, or the record's picture where no option mends it.
[[nodiscard]] std::string mending_fit(const FitCommand& command, const identify::Source& source,
                                      const identify::Identification& identification);

/// The same fit of the ladder instead of the named models.
[[nodiscard]] std::string command_of_ladder(const FitCommand& command);

/// What goes on after a fit with an accepted model: its report or a controller, or the same fit with its files.
/// @param written  models' files
[[nodiscard]] std::string next_of_fit(const FitCommand& command, const identify::Source& source,
                                      const identify::Identification& identification,
                                      const std::vector<std::filesystem::path>& written);

/// The command that draws the record into a picture: one on the terminal would lead back to the fit.
[[nodiscard]] std::string picture_of_record(const FitCommand& command);

/// What goes on where the model that is recommended, or comes nearest, shows why it errs: a fit of a structure that
/// explains what it leaves over, of a part within the limits of an input that saturates, or of a grey box that holds,
/// or the record of an output that wanders or drifts; none otherwise.
/// @param written  models' files, beside which a fit of another structure that explains nothing is not the next step
[[nodiscard]] std::optional<std::string> step_by_cause(const FitCommand& command, const identify::Source& source,
                                                       const identify::Identification& identification,
                                                       const std::vector<std::filesystem::path>& written);

}  // namespace eha::cli
