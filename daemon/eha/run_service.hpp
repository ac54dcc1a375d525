// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "core/error.hpp"

namespace eha::cli {

class Console;
struct RunCommand;

/// `eha run` without --local: submits the experiment to ehad, shows its progress and waits for its verdict.
[[nodiscard]] ExitCode run_through_service(const RunCommand& command, Console& console);

/// Of an experiment file: a rod beyond a travel limit must have been seen by a person, for which a run does not ask.
[[noreturn]] void refuse_way_back(const std::string& file);

}  // namespace eha::cli
