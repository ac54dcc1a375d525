// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace eha::ident {

/// Powers of tones that determine one parameter best within limits on signals.
struct ToneProblem {
  Eigen::MatrixXcd response;  ///< tones by parameters: derivative of G(j w_k) by each parameter
  Eigen::VectorXd noise;      ///< power of the noise at each tone
  Eigen::MatrixXd cost;       ///< limits by tones: share of a limit that unit power of a tone takes
  Eigen::Index target = 0;    ///< the parameter whose variance is minimised
};

/// Minimises the target's element of M^-1, M = sum_k P_k Re(g_k* g_k') / v_k, under C P <= 1, P >= 0, by multiplicative
/// updates of powers and of the limits' multipliers; starts from equal powers.
/// @returns P, scaled so that the tightest limit is met exactly. Cost: some hundred factorisations of M.
/// Fedorov, Theory of Optimal Experiments (1972); updates: Titterington, Biometrika 65 (1978).
[[nodiscard]] Eigen::VectorXd tone_powers(const ToneProblem& problem);

}  // namespace eha::ident
