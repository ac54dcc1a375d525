// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

namespace eha::record {

/// Refuses a file or folder that is a link: the folder of a run, of a fit or of a batch holds its own ones, and a link
/// in one that came from a stranger may lead to any file of the caller. What does not exist passes.
/// @throws DataError
void require_no_link(const std::filesystem::path& path);

/// The same for a file that the caller names, of which only a link of somebody else is refused; root's is not.
void require_no_link_of_others(const std::filesystem::path& path);

/// The path of a file that a text of the folder names, as run.json does "models/io.json": it stays in the folder, over
/// no link, and is no device or pipe. What does not exist passes.
/// @throws DataError
[[nodiscard]] std::filesystem::path listed_file(const std::filesystem::path& folder, const std::string& name);

}  // namespace eha::record
