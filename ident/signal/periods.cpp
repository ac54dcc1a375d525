// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/periods.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/statistics/distributions.hpp"

namespace eha::ident {
namespace {

// A period from a decimal frequency misses whole samples and cycles by rounding only.
constexpr double kWhole = 1e-6;
constexpr std::size_t kFewestPeriods = 2;
constexpr Eigen::Index kDriftDegree = 2;
constexpr double kByChance = 0.001;  // a drift is found

bool is_whole(double x) { return std::abs(x - std::round(x)) < kWhole; }

/// Legendre polynomials of degrees 1, 2 over the periods' rows.
Eigen::MatrixXd drift_basis(Eigen::Index rows) {
  const Eigen::ArrayXd x = Eigen::ArrayXd::LinSpaced(rows, -1.0, 1.0);
  Eigen::MatrixXd basis(rows, kDriftDegree);
  basis.col(0) = x;
  basis.col(1) = 1.5 * x.square() - 0.5;
  return basis;
}

/// Periods side by side, with each row's mean over them subtracted: the periodic part cancels.
Eigen::MatrixXd spread_of(const Eigen::Ref<const Eigen::MatrixXd>& periods) {
  return periods.colwise() - periods.rowwise().mean();
}

}  // namespace

std::size_t common_period(const std::vector<double>& lines_Hz, double step_s, std::size_t longest) {
  if (lines_Hz.empty()) return 0;
  for (double cycles = 1.0;; cycles += 1.0) {
    const double samples = cycles / (lines_Hz.front() * step_s);
    if (!(samples <= static_cast<double>(longest) + 0.5)) return 0;
    if (!is_whole(samples)) continue;
    bool all = true;
    for (const double f : lines_Hz) all = all && is_whole(f * step_s * std::round(samples));
    if (all) return static_cast<std::size_t>(std::llround(samples));
  }
}

Periods last_periods(std::size_t samples, std::size_t length, std::size_t discard) {
  const std::size_t count = length > 0 && discard < samples ? (samples - discard) / length : 0;
  if (count < kFewestPeriods) {
    throw DataError(
        fmt::format("periods: {} of {} rows in the {} that are left after discarding {}; expected at least {}: record "
                    "more repetitions or discard less",
                    count, length, samples - std::min(discard, samples), discard, kFewestPeriods));
  }
  return {samples - count * length, length, count};
}

PeriodicSignal average_periods(const Eigen::Ref<const Eigen::VectorXd>& signal, const Periods& periods, Drift drift) {
  const auto length = static_cast<Eigen::Index>(periods.length);
  const auto count = static_cast<Eigen::Index>(periods.count);
  const auto first = static_cast<Eigen::Index>(periods.first);
  if (length < 1 || periods.count < kFewestPeriods || first + length * count > signal.size()) {
    throw DataError(fmt::format("periods: {} of {} rows from row {} on; expected at least {} within {} rows", count,
                                length, first, kFewestPeriods, signal.size()));
  }
  const Eigen::Index rows = length * count;
  PeriodicSignal result;
  result.drift = Eigen::VectorXd::Zero(rows);
  result.periods = signal.segment(first, rows).reshaped(length, count);
  Eigen::MatrixXd spread = spread_of(result.periods);
  double freedom = static_cast<double>(length * (count - 1));
  if (drift == Drift::remove && freedom > static_cast<double>(kDriftDegree)) {
    const Eigen::MatrixXd basis = drift_basis(rows);
    Eigen::MatrixXd seen(rows, kDriftDegree);
    for (Eigen::Index d = 0; d < kDriftDegree; ++d) {
      seen.col(d) = spread_of(basis.col(d).reshaped(length, count)).reshaped();
    }
    const double before = spread.squaredNorm();
    const Eigen::VectorXd coefficients = solve_pivoted(seen, spread.reshaped());
    result.drift = basis * coefficients;
    result.drift.array() -= result.drift.mean();
    result.drift_range = result.drift.maxCoeff() - result.drift.minCoeff();
    result.periods -= result.drift.reshaped(length, count);
    spread = spread_of(result.periods);
    const auto parameters = static_cast<double>(kDriftDegree);
    freedom -= parameters;
    const double after = spread.squaredNorm();
    result.drift_detected =
        (before - after) / parameters > fisher_exceeded(kByChance, parameters, freedom) * after / freedom;
  }
  result.mean = result.periods.rowwise().mean();
  const double noise = spread.squaredNorm() / freedom;
  result.noise_std = std::sqrt(noise);
  const double power = (result.mean.array() - result.mean.mean()).square().mean();
  // The mean period also contains a share of the noise.
  const double signal_power = std::max(0.0, power - noise / static_cast<double>(count));
  result.signal_to_noise_dB =
      noise > 0.0 ? 10.0 * std::log10(signal_power / noise) : std::numeric_limits<double>::infinity();
  return result;
}

}  // namespace eha::ident
