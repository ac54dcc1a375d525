// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string_view>

#include "ident/output_error/output_error.hpp"
#include "ident/work.hpp"

namespace eha::ident {

/// Reason for the end of a local search.
enum class Termination {
  converged,         ///< neither the cost nor the coordinates change any more
  at_bound,          ///< converged with a coordinate on a bound
  no_progress,       ///< no smaller cost could be found along any damped step
  evaluation_limit,  ///< the evaluations were used up
  flat_ridge,        ///< they were, but the cost hardly falls any more: parameters trade for each other
  infeasible,        ///< the start is not a stable, proper model
};

[[nodiscard]] std::string_view text(Termination termination);

/// Whether the search ended at a minimum, be it a flat one.
[[nodiscard]] bool has_converged(Termination termination);

struct LeastSquaresOptions {
  std::size_t max_evaluations = 200;  ///< simulations, those of Jacobians included
  double cost_tolerance = 1e-12;      ///< relative fall of the cost that ends the search
  double step_tolerance = 1e-10;      ///< relative change of the output that ends the search
  /// Relative to Marquardt's scaling. A damped step hardly moves along a flat valley and may end the search there.
  double first_damping = 1e-3;
};

struct LeastSquaresResult {
  Eigen::VectorXd theta;
  OutputError::Point point;  ///< with Jacobian, once a search has begun
  Work work;
  Termination termination = Termination::infeasible;
  double damping = 0.0;         ///< to go on with; 0: not begun
  double predicted_cost = 0.0;  ///< after one undamped Gauss-Newton step, without bounds
};

/// Whether `a` is feasible and `b` is not, or has the higher cost.
[[nodiscard]] bool has_less_cost(const LeastSquaresResult& a, const LeastSquaresResult& b);

/// The start of a search, evaluated; an unstable one has its orders lowered until it is not.
[[nodiscard]] LeastSquaresResult begun(const OutputError& problem, const Eigen::VectorXd& start);

/// Goes on from where a search of the same problem was left, as minimise() does.
/// @param options  max_evaluations counts from here on
void proceed(const OutputError& problem, LeastSquaresResult& result, const LeastSquaresOptions& options = {});

/// Minimises the output error inside the coordinates' bounds from one start: Levenberg-Marquardt with Marquardt's
/// scaling and Nielsen's damping; coordinates on a bound that the descent pushes outward are held, steps that would
/// cross one are shortened to it and solved again for the rest. Trials that are unstable count as failed steps; an
/// unstable start has its orders lowered until it is not.
/// Nielsen, IMM-REP-1999-05, DTU (1999); projection: Kanzow, Yamashita and Fukushima, J. Comput. Appl. Math. 172
/// (2004).
[[nodiscard]] LeastSquaresResult minimise(const OutputError& problem, const Eigen::VectorXd& start,
                                          const LeastSquaresOptions& options = {});

}  // namespace eha::ident
