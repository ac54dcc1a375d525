// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace eha::ident {

/// The part between stretches of a signal in which it moves most: the greatest sum of squares about the part's mean. A
/// long part at rest tells nothing of a plant.
/// @param signal   one value a row, finite, of any unit
/// @param without  first and last rows, in ascending order of the first
/// @returns first row and the row behind the last; none where no part has a tenth of the signal's standard deviation.
/// Cost O(N).
[[nodiscard]] std::optional<std::pair<std::size_t, std::size_t>> most_moving_part(
    std::span<const double> signal, const std::vector<std::pair<std::size_t, std::size_t>>& without);

}  // namespace eha::ident
