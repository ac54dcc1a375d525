// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "ident/search/least_squares.hpp"

namespace eha::ident {

/// Continues a search from an optimum, with little damping, while the cost falls. The damped steps of a first search
/// hardly move along a flat valley and may end before the lowest point.
/// @param rounds  at most so many searches
[[nodiscard]] LeastSquaresResult followed_down(const OutputError& problem, LeastSquaresResult optimum, int rounds);

/// Follows every optimum down, the best first, until one leaves no error but that of the simulation.
void follow_down_all(const OutputError& problem, std::vector<LeastSquaresResult>& optima);

}  // namespace eha::ident
