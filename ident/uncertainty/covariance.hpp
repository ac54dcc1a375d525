// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace eha::ident {

/// Autoregressive model of a residual, its order chosen by BIC.
struct ResidualModel {
  std::vector<double> coefficients;    ///< e_k = sum_j c_j e_{k-j} + w_k; empty for white
  std::vector<double> autocovariance;  ///< gamma_0, gamma_1, ... as long as the residual
  double effective_samples = 0.0;      ///< n gamma_0 / sum of all gamma, at most n
};

/// Yule-Walker by Levinson's recursion, orders up to a tenth of the residual. Cost O(n order).
[[nodiscard]] ResidualModel residual_model(const Eigen::VectorXd& residual);

/// Covariance and correlation of least-squares estimates.
struct Uncertainty {
  Eigen::MatrixXd covariance;                  ///< p by p; without directions that do not move the output
  Eigen::MatrixXd correlation;                 ///< p by p
  Eigen::MatrixXd unit_covariance;             ///< p by p, (J'J)^-1 without those directions
  double interval_factor = 0.0;                ///< half width of a 95 % interval over the standard error (Student's t)
  std::vector<std::string> indistinguishable;  ///< parameters in such directions; their standard errors are infinite
};

/// Covariance of least-squares estimates whose residual is coloured,
///   (J'J)^-1 J' (Gamma n_eff / (n_eff - p) + W W') J (J'J)^-1,
/// which is sigma^2 (J'J)^-1 for a white residual and no W.
/// @param derivatives  n by p, of the simulated output by each parameter
/// @param input_error  W, n by m, as of input_walk(); empty: none
/// White, Econometrica 48 (1980); autoregressive spectrum: den Haan and Levin, Handbook of Statistics 15 (1997).
[[nodiscard]] Uncertainty uncertainty(const Eigen::MatrixXd& derivatives, const std::vector<std::string>& names,
                                      const ResidualModel& residual, const Eigen::MatrixXd& input_error = {});

/// Returns a root R of a covariance C that may be rank-deficient, R R' = C: p by p.
[[nodiscard]] Eigen::MatrixXd covariance_root(const Eigen::MatrixXd& covariance);

}  // namespace eha::ident
