// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/estimation/fit_choice.hpp"
#include "ident/output_error/output_error.hpp"

namespace eha::ident {

/// By how much BIC falls at most if an optimum at rest is moving before t = 0: the output is linearised there beside
/// the free responses, and may gain twice what that predicts. Infinite for a record too short to predict from, and
/// where the model grows.
/// @param rest    on the compared rows
/// @param moving  on the same rows, of the same structure; its coordinates are the first of the optimum's
/// @param free    parameters estimated of `moving`
/// Cost: a simulation with derivatives.
[[nodiscard]] double highest_moving_gain(const LocalOptimum& rest, const OutputError& moving, std::size_t free,
                                         Work& work);

/// A start in motion that may be searched beside optima at rest.
struct MovingStart {
  const ComparedRecord& compared;
  const Parametrisation& parametrisation;  ///< without the input's bias, which optima at rest may have as a coordinate
  const Variant& variant;
  const StructureOptions& asked;
  double duration_s;                ///< compared
  const std::vector<Model>& known;  ///< fitted to the same record
};

/// Whether the start gains too little over the best of the optima, at rest, to be chosen beside it. No where there is
/// none at rest that its search has settled at, or where a known model inside the structure is closer.
[[nodiscard]] bool is_needless(const MovingStart& start, const std::vector<LocalOptimum>& found, Work& work);

}  // namespace eha::ident
