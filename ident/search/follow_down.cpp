// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/search/follow_down.hpp"

#include <algorithm>
#include <utility>

namespace eha::ident {
namespace {

constexpr std::size_t kMostEvaluations = 2000;  // of a search that goes on from the chosen optimum
constexpr int kMostRounds = 10;
constexpr std::size_t kFewEvaluations = 300;
constexpr double kExactShare = 1e-18;  // of the output's energy; the simulation is exact to about 1e-10
constexpr double kHardlyDamped = 1e-14;
constexpr double kWorthwhileFall = 1e-3;

LeastSquaresResult in_rounds(const OutputError& problem, LeastSquaresResult optimum, int rounds, Patience patience) {
  const std::size_t evaluations = patience == Patience::full ? kMostEvaluations : kFewEvaluations;
  for (int round = 0; round < rounds && optimum.termination != Termination::infeasible; ++round) {
    LeastSquaresResult further =
        minimise(problem, optimum.theta, {.max_evaluations = evaluations, .first_damping = kHardlyDamped});
    Work work = optimum.work;
    work += further.work;
    const bool falls = further.point.cost < optimum.point.cost * (1.0 - kWorthwhileFall);
    if (further.termination != Termination::infeasible && further.point.cost <= optimum.point.cost) {
      optimum = std::move(further);
    }
    optimum.work = work;
    if (!falls) break;
  }
  return optimum;
}

}  // namespace

LeastSquaresResult followed_down(const OutputError& problem, LeastSquaresResult optimum, Patience patience) {
  return in_rounds(problem, std::move(optimum), 1, patience);
}

void follow_down_all(const OutputError& problem, std::vector<LeastSquaresResult>& optima, Patience patience) {
  std::stable_sort(optima.begin(), optima.end(), [](const LeastSquaresResult& a, const LeastSquaresResult& b) {
    const bool a_feasible = a.termination != Termination::infeasible;
    const bool b_feasible = b.termination != Termination::infeasible;
    return a_feasible && (!b_feasible || a.point.cost < b.point.cost);
  });
  for (LeastSquaresResult& optimum : optima) {
    optimum = in_rounds(problem, std::move(optimum), patience == Patience::full ? kMostRounds : 1, patience);
    if (optimum.point.cost <= kExactShare * problem.output_energy()) break;
  }
}

}  // namespace eha::ident
