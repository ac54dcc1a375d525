// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "ident/model/model.hpp"
#include "ident/record.hpp"

namespace eha::published {

/// Returns the model with the state estimated from the first rows of another record; keeps bias or map and permanent
/// offset. For whole orders the state has as many values as the order; for a fractional order, whose state is infinite,
/// the offset replaces it.
///   z = argmin sum_{k < rows} (y_k - y^_k(z))^2 / v + |z|^2 / w
/// with each z scaled to an effect of rms 1 over the record, v the mean square error on the estimating part and w the
/// mean square of the estimating output about its mean: a direction of z that the rows determine poorly stays near
/// rest.
/// @param rows             0: the model at rest
/// @param output_variance  w [output unit^2]
/// Cost: a simulation for each value of the state.
[[nodiscard]] ident::Model started(ident::Model model, const ident::Record& record, std::size_t rows,
                                   double output_variance);

}  // namespace eha::published
