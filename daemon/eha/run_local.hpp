// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/error.hpp"

namespace eha::cli {

class Console;
struct RunCommand;

/// `eha run --local`: opens the rig in this process, plays the experiments and reports each. Checks and rehearses all
/// of them before the first motion. The rig is safe on return and after an exception.
/// @throws Error  as each step; of several experiments, from before the first motion, as ListError
[[nodiscard]] ExitCode run_in_this_process(const RunCommand& command, Console& console);

}  // namespace eha::cli
