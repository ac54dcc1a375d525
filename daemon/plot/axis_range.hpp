// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <utility>

#include "daemon/plot/figure.hpp"

namespace eha::plot {

using Range = std::optional<std::pair<double, double>>;

/// Distance of the y axis' marks, three to six of them in the panel; gnuplot's own choice crowds low panels. Degrees
/// have parts of a turn. 0 where all values are equal.
[[nodiscard]] double y_step(const Panel& panel);

/// Ends of the y axis: gnuplot extends an automatic one to the next mark. None without a value.
[[nodiscard]] Range y_ends(const Panel& panel);

/// Range of the x axis that panels of numbers share: the data's, up to the next mark where it is near, so that a record
/// that ends one sample before 50 s shows the 50. None without a length.
[[nodiscard]] Range x_range_of(const Figure& figure);

/// Distance of the marks of an x axis; 0 without a length.
[[nodiscard]] double x_step(const Range& range);

}  // namespace eha::plot
