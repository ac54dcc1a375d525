// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "core/os/file_descriptor.hpp"

// The lock of a file that others may read. Who can open a file can take a flock(2) of it and keep its owner out; this
// lock (F_OFD_SETLK) is granted to who may write to the file alone. It belongs to the open file: it lasts until the
// last process that shares the descriptor has closed it.

namespace eha::os {

/// Takes the lock. Where readers have locked the file nothing is taken, and nobody waits for them.
/// @param file  open for writing   @param path  for messages
/// @returns false  another process has the lock
/// @throws IoError, PermissionError
[[nodiscard]] bool take_writer_lock(const FileDescriptor& file, const std::filesystem::path& path);

/// Whether another open file has the lock. @throws IoError, PermissionError
[[nodiscard]] bool has_writer(const FileDescriptor& file, const std::filesystem::path& path);

}  // namespace eha::os
