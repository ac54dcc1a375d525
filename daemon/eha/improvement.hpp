// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/error.hpp"

namespace eha::cli {

class Console;
struct DesignCommand;

/// Designs and writes the experiment that makes the standard error of a model's parameter smallest on a rig, and prints
/// what it predicts, how long it takes and which limit binds. With a wanted standard error the experiment becomes as
/// long as that takes, at most ten minutes; where that does not suffice it says so.
/// @throws ConfigError, IoError, PermissionError, UsageError
[[nodiscard]] ExitCode design_improvement(const DesignCommand& command, Console& console);

}  // namespace eha::cli
