// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "ident/export/sections.hpp"
#include "ident/fractional/transfer_function.hpp"

namespace eha::ident {

/// Whether every order of G is a whole number.
[[nodiscard]] bool has_whole_orders(const TransferFunction& g);

/// G of whole orders as a sum of sections, equal to it up to rounding, and in their states the free response
/// sum_i c_i s^i / D(s).
/// @param g              passes check(), has_whole_orders()
/// @param initial_state  c_i, i = 0.., fewer than D's degree
/// @throws ConfigError  initial_state is as long as D's degree or longer
/// Cost O(degree^3).
[[nodiscard]] Sections partial_fractions(const TransferFunction& g, const std::vector<double>& initial_state);

}  // namespace eha::ident
