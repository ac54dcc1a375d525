// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "daemon/importer/imported_table.hpp"

namespace eha::importer {

/// A row that is off an even grid by less than this share of a step is on it: times in single precision, jitter of a
/// clock.
inline constexpr double kOnGrid = 0.02;
/// A step of fewer digits within the tolerance is the round one that was meant.
inline constexpr int kMostStepDigits = 12;

/// The roundest period that drifts from so many rows by at most a quarter of it over the record [s].
[[nodiscard]] double round_period(double period_s, std::size_t rows);

/// Step of an evenly sampled time column [s].
///
/// A printed time is the true one rounded to its last digit, so a row may be up to half a unit of that digit off the
/// grid t_0 + k step. A step that is no whole number of such units (1/1024 s at six digits) shows as differences of two
/// neighbouring values. Rows within kOnGrid of an even grid are even.
/// @throws DataError  fewer than two rows, time that does not increase, a gap, or jitter: names the line, the
///                    step found there and the step expected, and a command that goes on: --resample; for a clock that
///                    shows several rows alike or drifts steadily --period; for several records one for each
/// @param rows  the first column is the time [s]
/// Cost O(N).
[[nodiscard]] double even_step_s(const Rows& rows, const std::filesystem::path& path, const Options& options);

}  // namespace eha::importer
