// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::os {

/// Processors that this process may run on, at least 1: fewer than the machine's under taskset, in a cpuset and in a
/// job of a batch system.
[[nodiscard]] unsigned usable_processors() noexcept;

}  // namespace eha::os
