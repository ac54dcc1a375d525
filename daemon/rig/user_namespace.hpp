// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha {

/// Whether uid 0 is the machine's root here, user_namespaces(7). False also where that cannot be told: without /proc,
/// with something mounted over the two files in it that tell, or on a kernel before 5.8.
[[nodiscard]] bool is_root_of_machine() noexcept;

}  // namespace eha
