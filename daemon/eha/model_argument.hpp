// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/eha/console.hpp"
#include "daemon/identify/source.hpp"
#include "ident/model/model.hpp"

namespace eha::cli {

/// Reads the model that a command line names. @throws UsageError  it is a run: names its models' folder
/// @throws ConfigError, IoError, PermissionError  as ident::model_from_text, os::read_file
[[nodiscard]] ident::Model read_model(const std::string& file);

/// The units of the rig file of the run that a model file lies in; empty where it lies in none.
[[nodiscard]] std::string rig_units_of_model(const std::string& file);

/// Warns where a model was estimated on the very run that it is now judged by: it says nothing about the rig of today.
void warn_of_own_record(const std::string& model_file, const identify::Source& source, const Console& console);

}  // namespace eha::cli
