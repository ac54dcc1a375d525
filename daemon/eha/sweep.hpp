// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>

#include "daemon/eha/commands.hpp"
#include "daemon/eha/identification.hpp"

namespace eha::cli {

/// `eha fit SOURCE --sweep commensurate`: fit and stability against the base order q, as a table and, under `folder`,
/// as sweep_commensurate.csv. The structure is the task's commensurate one, else one of two poles and no zero.
/// @throws as ident::sweep_commensurate_order; IoError, PermissionError
[[nodiscard]] ExitCode sweep_commensurate_order(const FitCommand& command, const IdentificationTask& task,
                                                const std::optional<std::filesystem::path>& folder, Console& console);

}  // namespace eha::cli
