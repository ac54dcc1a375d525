// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/executor.hpp"

namespace eha::cli {

/// An executor on threads that live for one call each.
/// @param threads  at most so many at a time, at least 1
/// The first exception of a task (lowest index) is thrown again in the caller once every thread has ended; tasks not
/// yet begun by then are left out. Thread-safe. Cost: some 20 us a thread and call.
[[nodiscard]] ident::Executor thread_executor(unsigned threads);

/// One thread for each processor this process may use.
[[nodiscard]] ident::Executor thread_executor();

}  // namespace eha::cli
