// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>

namespace eha::ident {

/// Runs task(0) .. task(count - 1), each once, in any order and possibly at the same time, and returns when all
/// are done. The caller chooses the number of threads; ident has none of its own.
using Executor = std::function<void(std::size_t count, const std::function<void(std::size_t)>& task)>;

/// Runs the tasks one after the other in the calling thread.
inline void run_in_order(std::size_t count, const std::function<void(std::size_t)>& task) {
  for (std::size_t i = 0; i < count; ++i) task(i);
}

}  // namespace eha::ident
