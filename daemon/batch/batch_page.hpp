// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/batch/batch_table.hpp"
#include "daemon/report/page.hpp"

namespace eha::batch {

/// Renders the table as a page: outliers, each parameter of the common model over the records with its intervals, the
/// recommended models, every record, and those not judged. Cost as report::assembled().
/// @param next  the command that goes on; empty or one that opens the page: not shown
[[nodiscard]] report::Page page_of(const Table& table, const std::string& next = {});

}  // namespace eha::batch
