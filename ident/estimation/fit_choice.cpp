// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/fit_choice.hpp"

#include <algorithm>
#include <cmath>

#include "ident/uncertainty/covariance.hpp"

namespace eha::ident {
namespace {

// A mode slower than this many records looks like an integrator.
constexpr double kResolvedRecords = 10.0;
// Few independent samples make all evidence weak; then the cost must not be larger than this factor.
constexpr double kNearlyAsGood = 1.25;

}  // namespace

double effective_bic(double cost, Eigen::Index rows, std::size_t free, double effective_samples) {
  return effective_samples * std::log(std::max(cost, 1e-300) / static_cast<double>(rows)) +
         static_cast<double>(free) * std::log(effective_samples);
}

bool looks_integrating(const LocalOptimum& optimum, double duration_s) {
  std::vector<Term> d = optimum.parametrisation.transfer_function(optimum.best.theta, {}).denominator;
  std::stable_sort(d.begin(), d.end(), [](const Term& a, const Term& b) { return a.order < b.order; });
  return std::any_of(d.begin() + 1, d.end(), [&](const Term& term) {
    const double gap = term.order - d[0].order;
    return std::pow(d[0].coefficient / term.coefficient, 1.0 / gap) * duration_s * kResolvedRecords < 1.0;
  });
}

const LocalOptimum& choose(const std::vector<LocalOptimum>& optima, double duration_s) {
  const auto by_cost = [](const LocalOptimum& a, const LocalOptimum& b) {
    return a.best.point.cost < b.best.point.cost;
  };
  const LocalOptimum& closest = *std::min_element(optima.begin(), optima.end(), by_cost);
  const double effective = residual_model(closest.best.point.residual).effective_samples;
  const auto bic = [&](const LocalOptimum& o) {
    return effective_bic(o.best.point.cost, o.best.point.residual.size(), o.free, effective);
  };
  const auto by_bic = [&](const LocalOptimum& a, const LocalOptimum& b) { return bic(a) < bic(b); };
  const LocalOptimum& best = *std::min_element(optima.begin(), optima.end(), by_bic);
  if (!looks_integrating(best, duration_s)) return best;
  const LocalOptimum* regular = nullptr;
  for (const LocalOptimum& o : optima) {
    const bool nearly =
        bic(o) - bic(best) < kStrongEvidence && o.best.point.cost <= kNearlyAsGood * best.best.point.cost;
    if (looks_integrating(o, duration_s) || !nearly) continue;
    if (regular == nullptr || bic(o) < bic(*regular)) regular = &o;
  }
  return regular != nullptr ? *regular : best;
}

}  // namespace eha::ident
