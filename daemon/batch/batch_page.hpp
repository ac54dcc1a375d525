// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "daemon/batch/table.hpp"
#include "daemon/report/page.hpp"

namespace eha::batch {

/// Renders the table as a page: outliers, each parameter of the common model over the records with its intervals, the
/// recommended models, every record, and those not judged. Depends on the table alone. Cost as report::assembled().
[[nodiscard]] report::Page page_of(const Table& table);

}  // namespace eha::batch
