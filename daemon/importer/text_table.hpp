// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "core/os/file_descriptor.hpp"
#include "daemon/importer/imported_table.hpp"

namespace eha::importer {

/// Opens delimited text; its dialect is guessed from the first lines. Reading takes constant memory apart from the
/// selected columns. @param text  an open file with the text of `path`, `kind` what that is; none: the file itself
/// @throws DataError, IoError, PermissionError
[[nodiscard]] std::unique_ptr<Table> open_text(const std::filesystem::path& path, const Options& options,
                                               os::FileDescriptor text = {}, const std::string& kind = "");

}  // namespace eha::importer
