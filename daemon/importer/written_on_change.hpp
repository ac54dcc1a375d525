// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace eha::importer {

/// Some loggers write a command only where it changes, and leave its cells empty in between. There it is known: held.
/// Fills them where more than half of the cells are empty, nearly each value is another one than the value before, and
/// the levels recur.
/// @returns what was done, for the user; none where the column is no such one
/// Cost O(N).
[[nodiscard]] std::optional<std::string> hold_written_on_change(std::vector<double>& command);

}  // namespace eha::importer
