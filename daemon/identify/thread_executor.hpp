// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/executor.hpp"

namespace eha::identify {

/// An executor whose threads live for one call each.
/// @param threads  greatest number at a time, at least 1
/// When tasks throw, the caller gets the exception of the task with the lowest index after every thread has ended;
/// tasks that have not begun do not run. Thread-safe. Cost: about 20 us for each thread and call.
[[nodiscard]] ident::Executor thread_executor(unsigned threads);

/// An executor with one thread for each processor that this process may use.
[[nodiscard]] ident::Executor thread_executor();

}  // namespace eha::identify
