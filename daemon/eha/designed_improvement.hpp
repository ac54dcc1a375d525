// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/error.hpp"

namespace eha::cli {

class Console;
struct DesignCommand;

/// Designs and writes the experiment that minimises the standard error of a model's parameter on a rig. Prints its
/// predicted result, its duration and the limit that binds. For a wanted standard error the experiment becomes as long
/// as necessary, at most ten minutes; prints a note if that does not suffice.
/// @throws ConfigError, IoError, PermissionError, UsageError
[[nodiscard]] ExitCode design_improvement(const DesignCommand& command, Console& console);

}  // namespace eha::cli
