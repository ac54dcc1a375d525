// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/correlation.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.hpp"
#include "ident/statistics/distributions.hpp"

namespace eha::ident {
namespace {

/// Two-sided 95 % and 99 % points of the standard normal distribution.
constexpr double kNormal95 = 1.959963984540054;
constexpr double kNormal99 = 2.5758293035489004;

/// @param weights  as autocorrelation(); rows of weight 0 are 0
Eigen::VectorXd without_mean(const Eigen::Ref<const Eigen::VectorXd>& signal, const char* name,
                             const Eigen::VectorXd& weights = {}) {
  if (signal.size() == 0) throw DataError(std::string("correlation: expected at least one sample of the ") + name);
  if (!signal.allFinite())
    throw DataError(std::string("the model's output grows beyond all numbers: a sample of the ") + name +
                    " is not finite");
  // A signal that is constant up to the rounding of its mean has no meaningful correlation.
  Eigen::VectorXd centred = signal.array() - signal.mean();
  if (weights.size() > 0) {
    centred = weights.cwiseProduct((signal.array() - weights.dot(signal) / std::max(1.0, weights.sum())).matrix());
  }
  const double rounding = 1e-14 * signal.cwiseAbs().maxCoeff();
  if (centred.cwiseAbs().maxCoeff() <= rounding) centred.setZero();
  return centred;
}

/// sum_t a(t) b(t - lag), lag >= 0.
double lagged_product(const Eigen::VectorXd& a, const Eigen::VectorXd& b, Eigen::Index lag) {
  const Eigen::Index overlap = a.size() - lag;
  return a.tail(overlap).dot(b.head(overlap));
}

int usable_lag(int max_lag, Eigen::Index samples) {
  return std::max(0, static_cast<int>(std::min<Eigen::Index>(max_lag, samples - 1)));
}

void set_bounds(Correlation& correlation, double standard_deviation) {
  correlation.bound95 = kNormal95 * standard_deviation;
  correlation.bound99 = kNormal99 * standard_deviation;
}

/// Parzen's weights: 1 at 0, 0 from 1 on, with a spectrum that is nowhere negative.
double parzen_weight(double x) { return x <= 0.5 ? 1.0 - 6.0 * x * x * (1.0 - x) : 2.0 * std::pow(1.0 - x, 3); }

/// N var r(k) for independent e and u: sum_j w(j / M) r_e(j) r_u(j), M the bandwidth.
double cross_correlation_variance(const Eigen::VectorXd& e, const Eigen::VectorXd& u, double power) {
  const Eigen::Index samples = e.size();
  if (samples < 2) return 1.0;
  const auto product = [&](Eigen::Index lag) {
    return lagged_product(e, e, lag) * lagged_product(u, u, lag) / (power * power);
  };
  // Andrews' plug-in bandwidth for Parzen's weights, the product process taken as first-order autoregressive.
  const double rho = std::clamp(product(1), -0.999, 0.999);
  const double alpha = 4.0 * rho * rho / std::pow(1.0 - rho, 4);
  const double bandwidth = 2.6614 * std::pow(alpha * static_cast<double>(samples), 0.2);
  const auto last = std::min<Eigen::Index>(samples - 1, static_cast<Eigen::Index>(bandwidth));
  double sum = 1.0;
  for (Eigen::Index j = 1; j <= last; ++j) sum += 2.0 * parzen_weight(static_cast<double>(j) / bandwidth) * product(j);
  return sum;
}

}  // namespace

double correlated_samples(Eigen::Index rows, const Eigen::VectorXd& weights) {
  const auto n = static_cast<double>(rows);
  return weights.size() == 0 ? n : weights.sum() * weights.sum() / n;
}

Correlation autocorrelation(const Eigen::Ref<const Eigen::VectorXd>& e, int max_lag, const Eigen::VectorXd& weights) {
  const Eigen::VectorXd centred = without_mean(e, "residual", weights);
  const double power = centred.squaredNorm();
  Correlation result;
  for (int lag = 0; lag <= usable_lag(max_lag, e.size()); ++lag) {
    result.lags.push_back(lag);
    // A share of the pairs is missing, the square of the share of rows.
    const double pairs = weights.size() > 0 && lag > 0 ? lagged_product(weights, weights, lag) : 0.0;
    const double scale =
        pairs > 0.0 ? weights.sum() * static_cast<double>(e.size() - lag) / (static_cast<double>(e.size()) * pairs)
                    : 1.0;
    result.values.push_back(power > 0.0 ? scale * lagged_product(centred, centred, lag) / power : 0.0);
  }
  set_bounds(result, 1.0 / std::sqrt(correlated_samples(e.size(), weights)));
  return result;
}

Correlation cross_correlation(const Eigen::Ref<const Eigen::VectorXd>& e, const Eigen::Ref<const Eigen::VectorXd>& u,
                              int max_lag, const Eigen::VectorXd& weights) {
  if (e.size() != u.size()) {
    throw DataError("correlation: expected as many samples of the input as of the residual, got " +
                    std::to_string(u.size()) + " and " + std::to_string(e.size()));
  }
  const Eigen::VectorXd residual = without_mean(e, "residual", weights);
  const Eigen::VectorXd input = without_mean(u, "input");
  const double samples = weights.size() > 0 ? weights.sum() : static_cast<double>(e.size());
  const double power = residual.norm() * input.norm() * std::sqrt(samples / static_cast<double>(e.size()));
  const int last = usable_lag(max_lag, e.size());
  Correlation result;
  for (int lag = -last; lag <= last; ++lag) {
    const double sum = lag >= 0 ? lagged_product(residual, input, lag) : lagged_product(input, residual, -lag);
    result.lags.push_back(lag);
    result.values.push_back(power > 0.0 ? sum / power : 0.0);
  }
  const double variance = power > 0.0 ? cross_correlation_variance(residual, input, power) : 1.0;
  set_bounds(result, std::sqrt(variance / samples));
  return result;
}

double ljung_box_p(const Correlation& acf, double samples) {
  const double n = samples;
  double sum = 0.0;
  int lags = 0;
  for (std::size_t i = 0; i < acf.lags.size(); ++i) {
    if (acf.lags[i] < 1 || !(acf.lags[i] < n)) continue;
    sum += acf.values[i] * acf.values[i] / (n - acf.lags[i]);
    ++lags;
  }
  if (lags == 0) return 1.0;
  return chi_squared_share(n * (n + 2.0) * sum, lags);
}

}  // namespace eha::ident
