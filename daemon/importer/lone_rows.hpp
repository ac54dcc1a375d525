// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace eha::importer {

/// Rows of an output that stand alone: up to three in a row that lie far from both neighbours, which agree with each
/// other, while the input does nothing of the kind. A rod cannot do that; a loose contact or a
/// disturbed sensor does. One is enough to spoil a model. So do up to a hundredth of the rows at once that lie
/// beyond 1.5 times the range of the others and are reached and left within one row, as 9999 in the place of readings.
/// None are rows into or out of which a motion goes on, nor rows at a step of the input or up to 5 behind it, unless
/// the output moves far more a volt there than after other steps.
/// @param input, output  of equal length; values that are not finite are passed over
/// @returns rows from 0, ascending; none where so many stand alone that it is the signal's own way. Cost O(N), and at
/// most O(N^2 / 10^4) of one that jumps beyond its range, and not back, in a hundredth of the rows.
[[nodiscard]] std::vector<std::size_t> lone_rows(std::span<const double> input, std::span<const double> output);

/// The same of an input: up to three rows in a row that lie beyond twice the range of the others, as where a decimal
/// point is lost. An excitation of pulses has no such range.
[[nodiscard]] std::vector<std::size_t> lone_inputs(std::span<const double> input);

/// "2 rows of the output stand alone, the first at 15.01 s: 0 between 65.1 and 65.2".
/// @param rows  at least one, of lone_rows() or lone_inputs()   @param name  "output" or "input"
[[nodiscard]] std::string lone_rows_text(const std::vector<std::size_t>& rows, std::span<const double> values,
                                         double first_s, std::string_view name = "output");

}  // namespace eha::importer
