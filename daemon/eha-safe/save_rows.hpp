// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstdint>

#include "core/guard_page.hpp"
#include "core/os/file_descriptor.hpp"

namespace eha {

/// Opens and locks the journal that a page names, to save rows after the guard.
/// @param owner  of the page: if that is another user, the journal must belong to that user, too
/// @returns none if there is no journal to complete, or its writer or guard lives
/// @throws IoError, PermissionError  it is not the file that the page names, or cannot be opened
[[nodiscard]] os::FileDescriptor open_journal(const GuardPage& page, uid_t owner);

/// Appends the rows that a dead process left in its page to its journal, in the blocks that the process would have
/// written; first cuts off a half-written block at the end of the file. May be repeated.
/// @param journal  open for reading and writing, its lock held
/// @returns rows written; 0 also if the process was in no run
/// @throws IoError, PermissionError  the journal cannot be written
std::uint64_t save_rows(GuardPage& page, const os::FileDescriptor& journal);

}  // namespace eha
