// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::importer {

/// Leaves this process what a reader needs and no more, for good: it opens no file but the one of `descriptor`, starts
/// no program, opens no socket, and sends no signal. A file that takes the reader over through a fault of its library
/// then has nothing to take. Kernels without Landlock (before 5.13) leave files readable; no kernel lets it change one.
/// @returns false where the kernel refuses system calls to be filtered
[[nodiscard]] bool confine_to(int descriptor) noexcept;

}  // namespace eha::importer
