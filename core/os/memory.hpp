// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::os {

/// Keeps freed memory of the process for its next arrays: no page is taken from the kernel, and cleared, a second time.
void keep_freed_memory() noexcept;

/// Gives large arrays back to the kernel when they are freed, as a process does that has not said otherwise.
void return_freed_memory() noexcept;

}  // namespace eha::os
