// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/estimation/fitted_optimum.hpp"
#include "ident/estimation/prepared_record.hpp"

namespace eha::ident {

/// By how much AR-BIC would fall if a fit's delay, held at 0, were estimated too, predicted without a search: the
/// output is linearised at delays of 0, 1, 4 and 16 steps of the search, beside the autoregressive model of the fit's
/// residual and without it, there with the effective samples. The best of the predictions counts. Infinite where there
/// are too few rows to tell.
/// @param work  counted on
/// Cost: eight simulations with derivatives.
[[nodiscard]] double predicted_delay_gain(const PreparedRecord& prepared, const FittedOptimum& fitted, Work& work);

}  // namespace eha::ident
