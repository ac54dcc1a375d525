// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/rest_before_step.hpp"

#include <cmath>

namespace eha::ident {
namespace {

constexpr double kStill = 0.01;
constexpr double kLevel = 0.05;

}  // namespace

std::optional<double> rest_of_step_test(const Eigen::Ref<const Eigen::VectorXd>& input,
                                        const Eigen::Ref<const Eigen::VectorXd>& output) {
  const double still = kStill * (input.maxCoeff() - input.minCoeff());
  const Eigen::Index last = input.size() - 1;
  Eigen::Index moved = 0;
  while (moved < last && std::abs(input[moved] - input[0]) <= still) ++moved;
  Eigen::Index settled = last;
  while (settled > 0 && std::abs(input[settled] - input[last]) <= still) --settled;
  // A filtered record shows one row between the levels.
  if (moved == 0 || settled > moved) return std::nullopt;
  // An input that takes effect at a row does not show in that row's output.
  const auto before = output.head(moved + 1);
  const bool level = before.maxCoeff() - before.minCoeff() <= kLevel * (output.maxCoeff() - output.minCoeff());
  return level ? std::optional(input.head(moved).mean()) : std::nullopt;
}

}  // namespace eha::ident
