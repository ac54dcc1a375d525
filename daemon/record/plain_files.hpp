// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

namespace eha::record {

/// Refuses a run folder with a pipe or a device in it, on which a reader would wait without end, or with a file of more
/// than 4 GiB, which no run has: a sparse one takes no space, and hours to read. Accepts a missing folder.
/// @throws DataError
void require_plain_files(const std::filesystem::path& folder);

}  // namespace eha::record
