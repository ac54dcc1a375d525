// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/moving_gain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ident/estimation/known_starts.hpp"
#include "ident/estimation/predicted_cost.hpp"
#include "ident/structure/parameter_requests.hpp"
#include "ident/uncertainty/covariance.hpp"

namespace eha::ident {

double highest_moving_gain(const LocalOptimum& rest, const OutputError& moving, std::size_t free, Work& work) {
  constexpr double kNotKnown = std::numeric_limits<double>::infinity();
  constexpr double kMostOfPredicted = 2.0;
  const Eigen::VectorXd& residual = rest.best.point.residual;
  const auto shared = static_cast<Eigen::Index>(moving.parametrisation().coordinates().size());
  if (residual.size() < kFewestRowsToPredict || rest.best.theta.size() < shared) return kNotKnown;
  const Eigen::VectorXd theta = rest.best.theta.head(shared);
  auto point = moving.evaluate(theta);
  work += moving.evaluation_work();
  work += moving.jacobian_work();
  if (!point || !moving.complete(theta, *point)) return kNotKnown;
  Eigen::VectorXd step;
  const double cost = predicted_cost(point->jacobian, point->residual, step);
  Eigen::VectorXd left = point->residual;
  if (step.size() > 0) left -= point->jacobian * step;
  // What the optimum at rest leaves is coloured by what it lacks.
  const double effective = std::max(residual_model(residual).effective_samples, residual_model(left).effective_samples);
  const double fall = effective * std::log(rest.best.point.cost / std::min(cost, rest.best.point.cost));
  return kMostOfPredicted * fall - (static_cast<double>(free) - static_cast<double>(rest.free)) * std::log(effective);
}

bool is_needless(const MovingStart& start, const std::vector<LocalOptimum>& found, Work& work) {
  const Variant& moving = start.variant;
  if (wants_past_input(start.asked) || moving.linear.initial_states == 0 || found.empty()) return false;
  const LocalOptimum& rest =
      *std::min_element(found.begin(), found.end(),
                        [](const LocalOptimum& a, const LocalOptimum& b) { return has_less_cost(a.best, b.best); });
  if (!has_converged(rest.best.termination) || rest.variant.linear.initial_states != 0) return false;
  const auto rows = static_cast<double>(rest.best.point.residual.size());
  const double least_known = least_known_error(start.parametrisation, start.known) * rows;
  if (rest.best.point.cost > (1.0 + kNoWorse) * least_known) return false;
  // Beside an optimum that looks integrating, choose() wants one that does not.
  if (!declares_integrator(start.asked) && looks_integrating(rest, start.duration_s)) return false;
  const Parametrisation& parametrisation = moving.bias_coordinate ? rest.parametrisation : start.parametrisation;
  const OutputError problem(start.compared, parametrisation, moving.linear);
  return highest_moving_gain(rest, problem, free_parameters(parametrisation, moving.linear), work) < 0.0;
}

}  // namespace eha::ident
