// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "core/guard_page.hpp"
#include "core/os/file_descriptor.hpp"

namespace eha {

/// How a guard's watch ended.
enum class WatchEnd {
  done,   ///< the line `done` came: the rig is safe
  death,  ///< the standard input ended without it
  stop,   ///< the same, the process having been stopped and killed here
  stall,  ///< the same, its loop having stood still and the process been killed here
};

/// What the guard watches beside its parent's life.
struct Watched {
  GuardPage* page = nullptr;           ///< of the parent; none: neither beats nor rows
  bool drives_machine = true;          ///< whether a loop that stands still is acted on
  std::function<bool()> switch_off{};  ///< the hydraulics, one try; empty: the rig has no enable line
  /// The journal that the parent handed over, with its lock, so that no process treats the record as complete before
  /// the rows are saved; none between runs.
  os::FileDescriptor journal{};
};

/// Waits until the parent process ends; standard input is the other end of its stream. A parent that stays stopped
/// (SIGSTOP, a debugger) leaves its last voltage on the output and the card locked: after about 0.3 s it is killed.
/// When a loop stands still for the page's limit (StallWatch), tells it to stop, lets it run on every processor with a
/// priority just below the guard's, and switches the hydraulics off. Kills a loop that stands still for 3.5 s more; at
/// once without an enable line. Prints nothing, because the reader of the messages may be stopped, too.
[[nodiscard]] WatchEnd watch_parent(Watched& watched);

/// Gives the guard what it needs to act in time: SCHED_FIFO kGuardPriority (or as much as is granted), any processor,
/// locked memory, sparing by the OOM killer. What is refused is left.
void become_guard() noexcept;

}  // namespace eha
