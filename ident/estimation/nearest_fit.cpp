// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/nearest_fit.hpp"

#include <algorithm>
#include <utility>

#include "ident/estimation/known_starts.hpp"
#include "ident/estimation/moving_gain.hpp"
#include "ident/estimation/variants.hpp"

namespace eha::ident {
namespace {

constexpr LeastSquaresOptions kEarly{.max_evaluations = 60, .cost_tolerance = 1e-6, .step_tolerance = 1e-5};

}  // namespace

std::optional<LocalOptimum> nearest_optimum(const NearestFit& fit, const std::vector<Model>& known, Work& work) {
  std::vector<LocalOptimum> optima;
  for (const Variant& variant : variants(fit.asked, fit.compared.past().size(), fit.rests_before)) {
    Parametrisation parametrisation = Parametrisation::search(fit.asked, fit.scale);
    const MovingStart moving{fit.compared, parametrisation, variant, fit.asked, fit.scale.duration_s, known};
    if (is_needless(moving, optima, work)) continue;
    const KnownStarts starts = known_starts(parametrisation, known, fit.scale);
    if (starts.at.empty()) return {};
    std::vector<Eigen::VectorXd> guesses;
    starts.append_to(guesses);
    if (variant.bias_coordinate) {
      parametrisation.add_input_bias(fit.asked, fit.largest_input, fit.first_input);
      const double bias = parametrisation.start().tail<1>()[0];
      for (Eigen::VectorXd& theta : guesses) {
        theta.conservativeResize(theta.size() + 1);
        theta.tail<1>()[0] = bias;
      }
    }
    const OutputError problem(fit.compared, parametrisation, variant.linear);
    LeastSquaresResult least;
    for (const Eigen::VectorXd& guess : guesses) {
      LeastSquaresResult start = begun(problem, guess);
      work += start.work;
      start.work = {};
      if (has_less_cost(start, least)) least = std::move(start);
    }
    if (least.termination == Termination::infeasible) continue;
    proceed(problem, least, kEarly);
    work += least.work;
    if (least.termination == Termination::infeasible) continue;
    optima.push_back({variant, parametrisation, std::move(least), free_parameters(parametrisation, variant.linear)});
  }
  if (optima.empty()) return {};
  return choose(optima, fit.scale.duration_s);
}

}  // namespace eha::ident
