// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace eha::ident {

/// Phases phi_k of a multisine whose signals
///   x_j(t) = sum_k Re(c_jk exp(i (2 pi h_k t / T + phi_k)))
/// all have low crest factors: minimises the L_p norm of all x_j / rms(x_j) together for p = 4, 8, ..., 64, one after
/// the other, from several random starts, by L-BFGS with the exact gradient (two FFTs of each signal an evaluation).
/// Guillaume, Schoukens, Pintelon and Kollar, IEEE Trans. Instrum. Meas. 40(6), 1991. Thread-safe.
/// @param harmonics  h_k, at least 1, rising
/// @param signals    c_j, one amplitude for each harmonic, at least one signal: the volts and responses to them
/// @param starts     at least 1; the best is kept
/// @returns [rad], 0..2 pi, one a harmonic
/// Cost: 30 harmonics and 12 starts take about 0.2 s a signal.
[[nodiscard]] Eigen::VectorXd low_peak_phases(const std::vector<std::size_t>& harmonics,
                                              const std::vector<Eigen::VectorXcd>& signals, int starts = 12,
                                              std::uint64_t seed = 1);

/// Greatest absolute value over RMS of one signal, on 32 points in the shortest period: 1.41 for a sine.
/// @param phase_rad  as low_peak_phases() returns them
[[nodiscard]] double crest_factor_of(const std::vector<std::size_t>& harmonics, const Eigen::VectorXcd& signal,
                                     const Eigen::VectorXd& phase_rad);

}  // namespace eha::ident
