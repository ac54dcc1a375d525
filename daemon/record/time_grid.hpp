// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "daemon/record/csv_columns.hpp"

namespace eha::record {

/// Step of an evenly sampled time column [s].
///
/// A printed time is the true one rounded to its last digit, so a row may be up to half a unit of that digit off the
/// grid t_0 + k step. A step that is no whole number of such units (1/1024 s at six digits) shows as differences of two
/// neighbouring values.
/// @throws DataError  fewer than two rows, time that does not increase, a gap, or jitter: names the line, the
///                    step found there and the step expected
/// Cost O(N).
[[nodiscard]] double even_step_s(const CsvColumns& columns, const std::filesystem::path& path);

}  // namespace eha::record
