// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/executor.hpp"

namespace eha::identify {

/// An executor whose threads live for one call each.
/// @param threads  greatest number at a time, at least 1
/// When tasks throw, the caller gets the exception of the one with the lowest index once every thread has ended; tasks
/// that have not begun by then do not run. Thread-safe. Cost: some 20 us a thread and call.
[[nodiscard]] ident::Executor thread_executor(unsigned threads);

/// One thread for each processor this process may use.
[[nodiscard]] ident::Executor thread_executor();

}  // namespace eha::identify
