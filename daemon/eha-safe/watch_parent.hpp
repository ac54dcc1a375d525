// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha {

/// How a guard's watch ended.
enum class WatchEnd {
  done,   ///< the line `done` came: the rig is safe
  death,  ///< the standard input ended without it
  kill,   ///< the same, the process having been stopped and killed here
};

/// Waits until the parent process ends; standard input is the other end of its stream. A parent that stays stopped
/// (SIGSTOP, a debugger) leaves its last voltage on the output and the card locked: after about 0.3 s it is killed.
/// Prints nothing, because the reader of the messages may be stopped, too.
[[nodiscard]] WatchEnd watch_parent();

}  // namespace eha
