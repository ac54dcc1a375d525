// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>

#include "ident/model/model.hpp"

namespace eha::ident {

/// @param mean_square  of the residual [output unit^2]
[[nodiscard]] InformationCriteria information(double mean_square, std::size_t parameters, double effective_samples);

/// Recomputes the criteria of all models with the effective samples of the one that fits best, because criteria compare
/// only when they count the same samples. All models were fitted to the same part of one record; those without criteria
/// stay as they are.
void compare_on_equal_terms(std::span<Model* const> models);

}  // namespace eha::ident
