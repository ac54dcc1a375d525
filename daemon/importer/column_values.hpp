// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace eha::importer {

/// Values that number rows: whole, each one more than the last, but where up to a tenth of the rows is missing.
[[nodiscard]] bool counts_rows(const std::vector<double>& values);

/// Values that may be a time: increasing, nine in ten by about the same.
[[nodiscard]] bool increases_evenly(const std::vector<double>& values);

}  // namespace eha::importer
