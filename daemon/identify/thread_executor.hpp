// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/executor.hpp"

namespace eha::identify {

/// Executor that creates its threads for each call.
/// @param threads  greatest number at a time, at least 1
/// If tasks throw, the caller receives the exception of the task with the lowest index after every thread has ended;
/// tasks that have not begun do not run. Thread-safe. Cost: about 20 us for each thread and call.
[[nodiscard]] ident::Executor thread_executor(unsigned threads);

/// Returns an executor with one thread for each processor that this process may use.
[[nodiscard]] ident::Executor thread_executor();

}  // namespace eha::identify
