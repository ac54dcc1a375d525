// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>

namespace eha::service {

/// Sends spdlog's default logger to standard error: with the level as sd-daemon(3) wants it ("<6>text") when that is
/// the journal, as "ehad: info: text" otherwise. A thread of its own writes, from a bounded queue. When nobody reads
/// standard error, the oldest messages are dropped, so logging never blocks. One message is one line: control
/// characters in it are replaced, and it has at most a few thousand bytes. Not for the loop's thread.
void set_up_log();

/// Logs how many messages were dropped since the last report, once there is room again. Call about every second.
void report_dropped_messages();

/// Waits until the messages so far are written. @returns false after `limit`: then leave by _exit(), because the log's
/// thread cannot be joined
[[nodiscard]] bool flush_log(std::chrono::milliseconds limit);

}  // namespace eha::service
