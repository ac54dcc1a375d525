// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string_view>

#include "core/os/file_descriptor.hpp"

namespace eha::os {

/// Locks a file that this user and root alone can open, which is made if it is missing; the lock lasts as long as the
/// result. Who can open a file can lock it and keep its owner out: one that others could open is replaced.
/// @param holder  who as a rule has the lock when it is held, and what to do then, for the message
/// @throws DeviceError      another process has the lock
/// @throws PermissionError  the file belongs to another user
/// @throws IoError          it is a link, or no file
[[nodiscard]] FileDescriptor lock_file(const std::filesystem::path& path, std::string_view holder);

}  // namespace eha::os
