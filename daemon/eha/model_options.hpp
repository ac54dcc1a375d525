// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "daemon/eha/commands.hpp"
#include "ident/estimation/fit_options.hpp"

namespace eha::cli {

/// The models that a command line asks for.
/// @param configured  the experiment's models; --model selects those of a structure, or a plain one if there is none;
///                    --structure adds the one of a file; without both all of them, or io and fo if there are none
/// @throws UsageError  a malformed NAME=VALUE, a structure asked for twice, --poles where no model has poles
/// @throws ConfigError, PermissionError  as config::load_structure
[[nodiscard]] std::vector<ident::StructureOptions> structures_for(
    const ModelOptions& options, const std::vector<ident::StructureOptions>& configured);

/// Overrides what the command line sets. @returns `options` changed
[[nodiscard]] ident::FitOptions with(ident::FitOptions options, const RecordOptions& record);

}  // namespace eha::cli
