// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>

#include "ident/model/model.hpp"

namespace eha::ident {

/// @param mean_square  of the residual [output unit^2]
[[nodiscard]] InformationCriteria information(double mean_square, std::size_t parameters, double effective_samples);

/// Criteria compare only when they count the same samples: recomputes those of all models, fitted to the same part of
/// one record, with the effective samples of the one that fits best. Models without criteria are left alone.
void compare_on_equal_terms(std::span<Model* const> models);

}  // namespace eha::ident
