// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace eha::ident {

/// Stability margins of a loop, from its open loop L(j w).
struct LoopMargins {
  bool is_stable = false;  ///< closed loop is stable; only then are the other members valid
  double ms = std::numeric_limits<double>::infinity();         ///< greatest |1 / (1 + L)|
  double mt = std::numeric_limits<double>::infinity();         ///< greatest |L / (1 + L)|
  double ms_rad_s = 0.0;                                       ///< frequency of ms [rad/s]
  double phase_deg = std::numeric_limits<double>::infinity();  ///< least, over the crossings |L| = 1; infinite: none
  double gain = std::numeric_limits<double>::infinity();       ///< least factor on L that destabilises the loop
  double delay_s = std::numeric_limits<double>::infinity();  ///< least additional delay that destabilises the loop [s]
  double crossover_rad_s = 0.0;                              ///< highest w with |L| = 1 [rad/s]; 0: none
};

/// Frequencies of equal ratio, both ends included. @param points  at least 2
[[nodiscard]] std::vector<double> log_grid(double low_rad_s, double high_rad_s, int points);

/// Margins of a loop whose open loop has no pole in the right half plane.
///   stable: arg(1 + L) turns by order_at_zero pi/2 from w = 0 to the end of the grid (Nyquist).
/// @param w_rad_s        rising, fine enough that 1 + L turns by less than half a turn from one to the next; L is small
///                       at the last or the last is the Nyquist frequency of a sampled loop
/// @param order_at_zero  n of L ~ 1/s^n at 0
/// Peaks are refined by a parabola in log w. Cost O(N).
[[nodiscard]] LoopMargins loop_margins(std::span<const double> w_rad_s, std::span<const std::complex<double>> open_loop,
                                       double order_at_zero);

/// max(Ms, Mt) of a stable loop, else infinity. Cost O(N), without the crossings.
[[nodiscard]] double sensitivity_peak(std::span<const double> w_rad_s, std::span<const std::complex<double>> open_loop,
                                      double order_at_zero);

}  // namespace eha::ident
