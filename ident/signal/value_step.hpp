// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>

namespace eha::ident {

/// The step of a coarsely rounded signal: the least difference of two of its values, of which all are whole multiples.
/// @returns 0 for fewer than 20 rows or three values, for more values than a fifth of the rows or most_values, and off
/// a grid Cost O(N log N), of a fine signal O(N).
[[nodiscard]] double value_step(std::span<const double> values, std::size_t most_values = 300);

/// Whether a coarsely rounded signal moves by single steps, where it moves: a converter read it that has no finer code.
/// A staircase moves by many. Cost as value_step()
[[nodiscard]] bool moves_by_single_steps(std::span<const double> values);

}  // namespace eha::ident
