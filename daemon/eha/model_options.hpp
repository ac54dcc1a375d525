// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "daemon/eha/commands.hpp"
#include "ident/estimation/fit_options.hpp"

namespace eha::cli {

/// The models that a command line asks for.
/// @param configured  those of the experiment; --model picks among them by structure, and where there is none of that
///                    structure takes a plain one; --structure adds the one of a file; with neither, io and fo
/// @throws UsageError  a malformed NAME=VALUE, a structure asked for twice, --poles where no model has poles
/// @throws ConfigError, PermissionError  as config::load_structure
[[nodiscard]] std::vector<ident::StructureOptions> structures_for(
    const ModelOptions& options, const std::vector<ident::StructureOptions>& configured);

/// Overrides what the command line sets. @returns `options` changed
[[nodiscard]] ident::FitOptions with(ident::FitOptions options, const RecordOptions& record);

}  // namespace eha::cli
