// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>

#include "ident/model/model.hpp"

namespace eha::ident {

/// The noise that a residual's correlation and power tell: by Levinson's recursion, the order of least BIC up to 10.
/// @param acf      lags 0, 1, ... among its lags
/// @param samples  of the residual that acf is of
/// @param power    mean square of the noise [output unit^2]
/// @returns nothing without a correlation, samples and a power above 0
[[nodiscard]] std::optional<ResidualNoise> noise_of(const Correlation& acf, std::size_t samples, double power);

/// Fills in what files did not hold at first, by guesses from the rest: structure, step between compared samples, noise
/// in them. What cannot be guessed stays empty.
void complete_earlier(Model& model);

}  // namespace eha::ident
