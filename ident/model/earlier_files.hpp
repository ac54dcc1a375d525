// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>

#include "ident/model/model.hpp"

namespace eha::ident {

/// Estimates the noise from a residual's correlation and power, by Levinson's recursion; BIC picks an order up to 10.
/// @param acf      lags 0, 1, ... among its lags
/// @param samples  number of samples of the residual
/// @param power    mean square of the noise [output unit^2]
/// @returns nothing without a correlation, samples and a power above 0
[[nodiscard]] std::optional<ResidualNoise> noise_of(const Correlation& acf, std::size_t samples, double power);

/// Fills in fields that early file versions lack, by estimates from the rest: structure, step between compared samples,
/// noise in them. A field without an estimate stays empty.
void complete_earlier(Model& model);

}  // namespace eha::ident
