// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "ident/search/least_squares.hpp"

namespace eha::ident {

/// How far an optimum is followed: a model that may not be wanted is worth a short search.
enum class Patience { full, little };

/// Continues a search from an optimum, with little damping, while the cost falls. The damped steps of a first search
/// hardly move along a flat valley and may end before the lowest point.
[[nodiscard]] LeastSquaresResult followed_down(const OutputError& problem, LeastSquaresResult optimum,
                                               Patience patience);

/// Follows every optimum down, search after search, the best first, until one leaves no error but that of the
/// simulation.
void follow_down_all(const OutputError& problem, std::vector<LeastSquaresResult>& optima, Patience patience);

}  // namespace eha::ident
