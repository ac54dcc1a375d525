// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/delay_gain.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "ident/estimation/predicted_cost.hpp"
#include "ident/estimation/valve_starts.hpp"
#include "ident/signal/autoregression.hpp"
#include "ident/structure/parameter_requests.hpp"
#include "ident/uncertainty/covariance.hpp"

namespace eha::ident {
namespace {

constexpr double kUnknownGain = std::numeric_limits<double>::infinity();
constexpr std::array<double, 4> kTriedSteps = {0.0, 1.0, 4.0, 16.0};

/// The optimum's coordinates among those with a delay, which is left at 0; its index. Nothing where others differ too.
std::optional<Eigen::Index> place(const LocalOptimum& optimum, const Parametrisation& with, Eigen::VectorXd& theta) {
  const std::vector<Coordinate>& from = optimum.parametrisation.coordinates();
  const std::vector<Coordinate>& to = with.coordinates();
  std::optional<Eigen::Index> delay;
  theta.setZero(static_cast<Eigen::Index>(to.size()));
  for (std::size_t l = 0; l < to.size(); ++l) {
    const auto i = static_cast<Eigen::Index>(l);
    const auto same = std::find_if(from.begin(), from.end(), [&](const Coordinate& c) {
      return c.role == to[l].role && c.key.name == to[l].key.name;
    });
    if (same != from.end()) {
      theta[i] = optimum.best.theta[same - from.begin()];
    } else if (to[l].role == CoordinateRole::delay && !delay) {
      delay = i;
    } else {
      return std::nullopt;
    }
  }
  return from.size() + 1 == to.size() ? delay : std::nullopt;
}

/// The fall of samples ln(cost) less what one parameter more is charged. @param theta  with the delay at 0
double gain(const OutputError& problem, Eigen::VectorXd theta, Eigen::Index delay, double step_s, double samples,
            Work& work) {
  const double longest = problem.parametrisation().coordinates()[static_cast<std::size_t>(delay)].search_upper;
  double without = kUnknownGain;
  double least = kUnknownGain;
  for (const double steps : kTriedSteps) {
    theta[delay] = std::min(steps * step_s, longest);
    auto point = problem.evaluate(theta);
    work += problem.evaluation_work();
    work += problem.jacobian_work();
    if (!point || !problem.complete(theta, *point)) continue;
    Eigen::VectorXd step;
    const double cost = predicted_cost(point->jacobian, point->residual, step);
    if (steps > 0.0) {
      least = std::min(least, cost);
      continue;
    }
    // No delay is shorter than 0.
    if (step[delay] > 0.0) least = cost;
    point->jacobian.col(delay).setZero();
    without = predicted_cost(point->jacobian, point->residual, step);
  }
  if (!std::isfinite(without)) return kUnknownGain;
  return samples * std::log(without / std::min(least, without)) - std::log(samples);
}

}  // namespace

double predicted_delay_gain(const PreparedRecord& prepared, const FittedOptimum& fitted, Work& work) {
  StructureOptions asked = fitted.searched;
  asked.structure.delay.freedom = Freedom::free;
  const LocalOptimum& optimum = fitted.optimum;
  Parametrisation with = Parametrisation::search(asked, fitted.scale);
  const Eigen::VectorXd& input = prepared.record.input;
  if (optimum.variant.bias_coordinate) with.add_input_bias(asked, input.cwiseAbs().maxCoeff(), input[0]);
  Eigen::VectorXd theta;
  const std::optional<Eigen::Index> delay = place(optimum, with, theta);
  const ComparedRecord& compared = prepared.compared({wants_past_input(asked), asked_behind_valve(asked).has_value()});
  if (!delay || compared.measured().size() < kFewestRowsToPredict) return kUnknownGain;

  const Eigen::VectorXd residual = OutputError(compared, optimum.parametrisation, optimum.variant.linear)
                                       .residual(optimum.best.theta, optimum.best.point.linear);
  // What a delay explains may pass for the noise's colour; then the plain cost shows it.
  const double step_s = fitted.scale.step_s;
  const OutputError plain(compared, with, optimum.variant.linear);
  const OutputError coloured(compared, with, optimum.variant.linear, autoregression(residual));
  return std::max(gain(plain, theta, *delay, step_s, residual_model(residual).effective_samples, work),
                  gain(coloured, theta, *delay, step_s, static_cast<double>(residual.size()), work));
}

}  // namespace eha::ident
