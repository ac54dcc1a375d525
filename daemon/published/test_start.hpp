// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "ident/model/model.hpp"
#include "ident/record.hpp"

namespace eha::published {

/// Returns the model with the state estimated from the first rows of another record; keeps bias or map and permanent
/// offset. The state is that of the model in the estimating record, moved by what the first rows of the two records
/// differ in. What the model errs by at the start of the estimating record it may err by again: an integrator without
/// the plant's friction moves off too early, and a state fitted to its first rows would carry that error through the
/// whole test.
///   d = argmin sum_{k < rows} ((y_k - y^_k(z + d)) - r_k)^2 / v + |d|^2 / w
/// with z the estimating state, r the residual of the estimating record's first rows, each d scaled to an effect of rms
/// 1 over the record, v the mean square error on the estimating part and w the mean square of its output about its
/// mean: a direction of d that the rows determine poorly stays near 0. For whole orders the state has as many values as
/// the order; for a fractional order, whose state is infinite, the offset replaces it. Of a grey box d moves its
/// states, in rounds of Gauss and Newton.
/// @param rows        0: the model at rest
/// @param estimating  the part that estimated the model, from its first row
/// Cost: a simulation of either record and one for each value of the state.
[[nodiscard]] ident::Model started(ident::Model model, const ident::Record& record, std::size_t rows,
                                   const ident::Record& estimating);

}  // namespace eha::published
