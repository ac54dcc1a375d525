// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "core/guard_page.hpp"
#include "core/os/file_descriptor.hpp"

namespace eha {

/// Reason for the end of a guard's watch.
enum class WatchEnd {
  done,   ///< the line `done` came: the rig is safe
  death,  ///< the standard input ended without `done`
  stop,   ///< the same: the process was stopped, and killed by the guard
  stall,  ///< the same: the loop stalled, and the process was killed by the guard
};

/// Inputs of the guard, beside its parent's life.
struct Watched {
  GuardPage* page = nullptr;           ///< of the parent; none: neither beats nor rows
  bool drives_machine = true;          ///< act on a stalled loop
  std::function<bool()> switch_off{};  ///< switches the hydraulics off in one try; empty: the rig has no enable line
  /// The journal from the parent, with its lock, so that no process treats the record as complete before the rows are
  /// saved; none between runs.
  os::FileDescriptor journal{};
};

/// Waits until the parent process ends; standard input is the other end of its stream. A parent that stays stopped
/// (SIGSTOP, a debugger) leaves its last voltage on the output and the card locked: after about 0.3 s it is killed. If
/// a loop stalls for the page's limit (StallWatch), tells it to stop, lets it run on every processor with a priority
/// just below the guard's, and switches the hydraulics off. Kills the loop if it stalls for 3.5 s more, or at once
/// without an enable line. Prints nothing, because the reader of the messages may be stopped, too.
[[nodiscard]] WatchEnd watch_parent(Watched& watched);

/// Prepares the guard to act in time: SCHED_FIFO kGuardPriority (or as much as is granted), any processor, locked
/// memory, protection from the OOM killer. Ignores refusals.
void become_guard() noexcept;

}  // namespace eha
