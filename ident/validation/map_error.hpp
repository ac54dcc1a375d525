// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>

#include "ident/model/model.hpp"
#include "ident/model/model_output.hpp"

namespace eha::ident {

/// Greatest error of a valve map beside its edges, at the map's output: the residual is explained by an output of the
/// map that is off by a constant within each half of the dead band, as far again beyond either edge, and farther on.
///   e(t) = c_0 + sum_b c_b G(1_b(u))(t) + slopes;  the greatest |c_b| beyond two standard errors, of the four inner b
/// Oil that leaks past a piston moves the rod within the dead band. The fit bends null and dead band towards that, and
/// their intervals, which take the map for the valve's, do not hold it.
/// @param outputs   on the record that `residual` is of  @param residual  of all compared rows
/// @returns [input unit]; none without a map or a dead band, for a model that grows, or on fewer than 60 rows
/// Cost eight responses.
[[nodiscard]] std::optional<double> map_error(const Model& model, OutputOnRecord& outputs,
                                              const Eigen::VectorXd& residual);

/// Null and dead band of a fit may be off by this many times that error, see MapError in the tests.
inline constexpr double kShiftOverMapError = 2.0;

}  // namespace eha::ident
