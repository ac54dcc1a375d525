// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "daemon/eha/commands.hpp"
#include "ident/estimation/fit_options.hpp"
#include "ident/estimation/ladder.hpp"

namespace eha::cli {

/// The models that a command line asks for.
/// @param configured  the experiment's models; --model selects those of a structure, or a plain one if there is none;
///                    --structure adds the one of a file; without both all of them: none where there are none, and the
///                    ladder is to be climbed with ladder_for()
/// @throws UsageError  a malformed NAME=VALUE, a structure asked for twice, --poles where no model has poles
/// @throws ConfigError, PermissionError  as config::load_structure
[[nodiscard]] std::vector<ident::StructureOptions> structures_for(
    const ModelOptions& options, const std::vector<ident::StructureOptions>& configured);

/// What the options want of every structure of the ladder; --poles and --zeros are those of its `io`.
/// @throws UsageError  as structures_for()
[[nodiscard]] ident::LadderOptions ladder_for(const ModelOptions& options);

/// Overrides what the command line sets. @returns `options` changed
[[nodiscard]] ident::FitOptions with(ident::FitOptions options, const RecordOptions& record);

}  // namespace eha::cli
