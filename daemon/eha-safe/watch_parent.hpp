// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha {

/// How a guard's watch ended.
enum class WatchEnd {
  done,   ///< the line `done` came: the rig is safe
  death,  ///< the standard input ended without it
  kill,   ///< the same, the process having been stopped and killed here
};

/// Waits for the end of the process that started this one, whose end of the stream is this one's standard input. A
/// process that is stopped (SIGSTOP, a debugger) leaves its last voltage on the output and the card locked: when it has
/// been so for about 0.3 s it is killed. Says nothing: whoever reads the messages may be stopped, too.
[[nodiscard]] WatchEnd watch_parent();

}  // namespace eha
