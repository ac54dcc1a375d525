// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "ident/model/model.hpp"
#include "ident/record.hpp"

namespace eha::published {

/// The model with the state that the first rows of another record tell; bias or map and permanent offset are kept. Of a
/// model of whole orders the state has as many values as the order, of one with a fractional order, whose state has no
/// end, the offset stands for it.
///   z = argmin sum_{k < rows} (y_k - y^_k(z))^2 / v + |z|^2 / w
/// with each z scaled to an effect of rms 1 over the record, v the mean square error on the estimating part and w the
/// mean square of the estimating output about its mean: rows that tell a direction of z badly leave it near rest.
/// @param rows             0: the model at rest
/// @param output_variance  w [output unit^2]
/// Cost: a simulation for each value of the state.
[[nodiscard]] ident::Model started(ident::Model model, const ident::Record& record, std::size_t rows,
                                   double output_variance);

}  // namespace eha::published
