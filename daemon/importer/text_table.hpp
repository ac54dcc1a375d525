// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>

#include "daemon/importer/table.hpp"

namespace eha::importer {

/// Opens delimited text; its dialect is guessed from the first lines. Reading takes constant memory apart from the
/// selected columns. @throws DataError, IoError, PermissionError
[[nodiscard]] std::unique_ptr<Table> open_text(const std::filesystem::path& path, const Options& options);

}  // namespace eha::importer
