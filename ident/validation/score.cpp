// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/score.hpp"

#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace eha::ident {
namespace {

/// 1 - ratio of a residual's size to the signal's, in percent.
double percent_explained(double residual, double signal) {
  if (signal > 0.0) return 100.0 * (1.0 - residual / signal);
  return residual > 0.0 ? -std::numeric_limits<double>::infinity() : 100.0;
}

}  // namespace

Score score(const Eigen::Ref<const Eigen::VectorXd>& measured, const Eigen::Ref<const Eigen::VectorXd>& simulated) {
  if (measured.size() != simulated.size() || measured.size() == 0) {
    throw DataError("score: expected as many simulated as measured samples and at least one, got " +
                    std::to_string(simulated.size()) + " and " + std::to_string(measured.size()));
  }
  const Eigen::VectorXd e = measured - simulated;
  const double residual = e.squaredNorm();
  const double signal = (measured.array() - measured.mean()).matrix().squaredNorm();
  Score result;
  result.samples = static_cast<std::size_t>(e.size());
  result.r2_percent = percent_explained(residual, signal);
  result.fit_percent = percent_explained(std::sqrt(residual), std::sqrt(signal));
  result.mse = residual / static_cast<double>(e.size());
  result.error_min = e.minCoeff();
  result.error_max = e.maxCoeff();
  return result;
}

}  // namespace eha::ident
