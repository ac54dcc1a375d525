// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "daemon/eha/console.hpp"
#include "daemon/identify/source.hpp"
#include "ident/model/model.hpp"
#include "ident/signal/intersample.hpp"

namespace eha::cli {

/// Reads the model that a command line names. @throws UsageError  it is a run; the message names its models' folder
/// @throws ConfigError, IoError, PermissionError  as ident::model_from_text, os::read_file
[[nodiscard]] ident::Model read_model(const std::string& file);

/// Returns the units of the rig file of the run that contains a model file; empty if no run contains it.
[[nodiscard]] std::string rig_units_of_model(const std::string& file);

/// The record that a model was estimated on, as its file names it; empty without one.
[[nodiscard]] std::string record_of(const ident::Model& model);

/// Whether two names are of one record: a file, or the folder of a run. False for an empty name.
[[nodiscard]] bool is_one_record(const std::string& a, const std::string& b);

/// What the input does between its rows: as the option says, else as it was taken for the model, which is said in a
/// line.
[[nodiscard]] ident::Intersample intersample_for(const std::optional<ident::Intersample>& given,
                                                 const ident::Model& model, const Console& console);

/// Says that a model was estimated on the very run that scores it; empty where it was not, and of a file.
[[nodiscard]] std::string own_record_text(const std::string& model_file, const identify::Source& source);
/// Warns of that.
void warn_of_own_record(const std::string& model_file, const identify::Source& source, const Console& console);

}  // namespace eha::cli
