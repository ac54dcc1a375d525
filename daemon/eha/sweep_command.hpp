// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>

#include "core/error.hpp"
#include "daemon/identify/identification.hpp"

namespace eha::cli {

class Console;
struct FitCommand;

/// `eha fit SOURCE --sweep commensurate`: prints fit and stability against the base order q as a table and, under
/// `folder`, writes sweep_commensurate.csv.
/// @throws as identify::sweep_commensurate_order; IoError, PermissionError
[[nodiscard]] ExitCode sweep_commensurate_order(const FitCommand& command, const identify::IdentificationTask& task,
                                                const std::optional<std::filesystem::path>& folder, Console& console);

}  // namespace eha::cli
