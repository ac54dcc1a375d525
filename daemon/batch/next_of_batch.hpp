// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/batch/batch_folder.hpp"
#include "daemon/batch/batch_table.hpp"

namespace eha::batch {

/// The command that goes on after a table, for what its page names first: `eha compare` of a record that lies apart
/// with the most ordinary one, or of the first record with the last where a parameter moves; the fit of a record that
/// could not be judged, or is not compared; `eha compare` of records too few for a table; else the page. Records that
/// only options make readable, which `eha compare` does not have, are compared by their models.
[[nodiscard]] std::string next_command(const BatchFolder& folder, const Table& table);

}  // namespace eha::batch
