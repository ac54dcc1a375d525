// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/error.hpp"

namespace eha::cli {

class Console;
struct RunCommand;

/// `eha run` without --local: submits the experiment to ehad, shows its progress and waits for its verdict.
[[nodiscard]] ExitCode run_through_service(const RunCommand& command, Console& console);

}  // namespace eha::cli
