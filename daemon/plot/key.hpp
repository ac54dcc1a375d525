// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "daemon/plot/figure.hpp"

// The key above a panel: how much room its entries take. Pixels are those of a picture 600 wide.

namespace eha::plot {

inline constexpr double kKeyWidth_px = 490.0;

/// Estimated width of a text in letters of the lower case: digits and capitals are wider, m and w most.
[[nodiscard]] double letters_of(std::string_view text);

/// Lines of a panel's key, with the entries of its curves, rules and shades.
[[nodiscard]] std::size_t key_lines(const Panel& panel);

/// The command that sets the key's width. gnuplot reserves 0.7 em for a letter of the key, more than it needs: with
/// less width more entries fit into a row.
[[nodiscard]] std::string key_width(const Panel& panel);

}  // namespace eha::plot
