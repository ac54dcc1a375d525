// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstdint>

#include "core/guard_page.hpp"
#include "core/os/file_descriptor.hpp"

namespace eha {

/// The journal that a page names, locked, for saving rows after the guard.
/// @param owner  of the page: if that is another user, the journal must belong to that user too
/// @returns none when there is no journal to complete, or its writer or guard lives
/// @throws IoError, PermissionError  it is not the file that the page names, or cannot be opened
[[nodiscard]] os::FileDescriptor open_journal(const GuardPage& page, uid_t owner);

/// Appends to the journal of a dead process the rows that it left in its page, in blocks as the process itself would
/// have written them; a half-written block at the end of the file is cut off before. Repeating it does no harm.
/// @param journal  open for reading and writing, its lock held
/// @returns rows written; 0 also when the process was in no run
/// @throws IoError, PermissionError  the journal cannot be written
std::uint64_t save_rows(GuardPage& page, const os::FileDescriptor& journal);

}  // namespace eha
