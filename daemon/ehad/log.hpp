// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::service {

/// Sends spdlog's default logger to standard error: with the level as sd-daemon(3) wants it ("<6>text") when that is
/// the journal, as "ehad: info: text" otherwise. Not for the loop's thread.
void set_up_log();

}  // namespace eha::service
