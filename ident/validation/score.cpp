// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/score.hpp"

#include <algorithm>
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

/// A signal less its mean over up to `half` samples on either side.
Eigen::VectorXd faster_part(const Eigen::VectorXd& y, Eigen::Index half) {
  Eigen::VectorXd sums(y.size() + 1);
  sums[0] = 0.0;
  for (Eigen::Index k = 0; k < y.size(); ++k) sums[k + 1] = sums[k] + y[k] - y[0];
  Eigen::VectorXd faster(y.size());
  for (Eigen::Index k = 0; k < y.size(); ++k) {
    // As wide on either side, so that a ramp is its own mean.
    const Eigen::Index width = std::min({half, k, y.size() - 1 - k});
    faster[k] = y[k] - y[0] - (sums[k + width + 1] - sums[k - width]) / static_cast<double>(2 * width + 1);
  }
  return faster;
}

}  // namespace

std::optional<double> r2_of_faster_percent(const Eigen::VectorXd& measured, const Eigen::VectorXd& simulated) {
  constexpr Eigen::Index kFewest = 100;
  constexpr Eigen::Index kPart = 20;  // half of the window, of all
  if (measured.size() < kFewest || measured.size() != simulated.size()) return std::nullopt;
  const double r2 =
      score(faster_part(measured, measured.size() / kPart), faster_part(simulated, measured.size() / kPart)).r2_percent;
  return std::isfinite(r2) ? std::optional(r2) : std::nullopt;
}

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
