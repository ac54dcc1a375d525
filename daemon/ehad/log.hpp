// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>

namespace eha::service {

/// Sends spdlog's default logger to standard error: with the level in the form of sd-daemon(3) ("<6>text") if that is
/// the journal, as "ehad: info: text" otherwise. A separate thread writes from a bounded queue. If nobody reads
/// standard error, the oldest messages are dropped, so logging never blocks. One message is one line: control
/// characters in it are replaced, and it has at most a few thousand bytes. Not for the loop's thread.
void set_up_log();

/// Logs the number of messages dropped since the last report, once there is room again. Call about every second.
void report_dropped_messages();

/// Waits until the messages so far are written. @returns false after `limit`; leave by _exit() then, because the log's
/// thread cannot be joined
[[nodiscard]] bool flush_log(std::chrono::milliseconds limit);

}  // namespace eha::service
