// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/estimation/fitted_optimum.hpp"
#include "ident/estimation/prepared_record.hpp"

namespace eha::ident {

/// By how much AR-BIC would fall, but for the price of the parameters, if a valve map stood before a fitted model,
/// predicted without a search: the output is linearised at the model behind maps with the dead bands of kDeadBands,
/// beside the autoregressive model of the fit's residual and without it, there with the effective samples. The best of
/// the predictions counts. A map that explains much gains up to five times as much as predicted. Infinite where a map
/// cannot be put before the model, or where there are too few rows to tell.
/// @param behind_map  the structure of the fit behind the map
/// @param work        counted on
/// Cost: eight simulations with derivatives behind a map, twice that where the start of the record has two readings.
[[nodiscard]] double predicted_valve_gain(const PreparedRecord& prepared, const FittedOptimum& fitted,
                                          const StructureOptions& behind_map, Work& work);

}  // namespace eha::ident
