// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string_view>
#include <vector>

#include "ident/model/model.hpp"
#include "ident/model/model_output.hpp"

namespace eha::ident {

/// Signals of one kind of nonlinear effect at the compared rows, which a linear model lacks: n by m.
struct NonlinearEffects {
  NonlinearKind kind;
  Eigen::MatrixXd columns;
};

// Columns G |v| and G v|v| of the effects of kind level. A residual along the second is of a gain that grows with the
// input.
inline constexpr Eigen::Index kEvenLevel = 0;
inline constexpr Eigen::Index kOddLevel = 4;

/// With v the input behind the model's map, about its mean, and without the noise of its channel (held_levels()), d the
/// direction of its last change, G the model's transfer function and y its output, about its mean:
///   level:     G |v|, G v|v|, G v^3, and |v|, v|v|, v^3 at three lags: a gain or an opening that changes with v;
///   direction: G d, and d at three lags: play, hysteresis, a limited rate;
///   motion:    the sign of y's change at lags 0, 1, 3: dry friction;
///   position:  G(v y), and y^2, y^3 at lags 0, 1, 3: a gain that changes with the position, a bent sensor;
///   time:      G(v t), G(v t^2), with t from -1 to 1 over the record: a gain that drifts, as in oil that warms up.
/// Lags count compared rows, those of the input from least_input_lag() on. Uses the model's output, not the measured
/// one, which contains noise.
/// @param first  first compared row wanted, at least 4
[[nodiscard]] std::vector<NonlinearEffects> nonlinear_effects(const Model& model, OutputOnRecord& outputs,
                                                              std::size_t first);

}  // namespace eha::ident
