// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/importer/imported_table.hpp"

// The columns of a file as messages name them.

namespace eha::importer {

/// "rec." of "rec.u"
[[nodiscard]] std::string_view prefix_of(std::string_view label);

/// The columns for a message.
[[nodiscard]] std::string listed(const std::vector<Column>& columns);

/// A column for a message: `2 "Spannung [V]"`.
[[nodiscard]] std::string described(const std::vector<Column>& columns, std::size_t index);
/// The same with the unit where the label does not say it: `2 "Spannung" [V]`.
[[nodiscard]] std::string described_with_unit(const std::vector<Column>& columns, std::size_t index);

}  // namespace eha::importer
