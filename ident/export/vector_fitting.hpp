// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <vector>

#include "ident/export/sections.hpp"
#include "ident/fractional/transfer_function.hpp"

namespace eha::ident {

/// Frequencies of an approximation [rad/s].
struct AngularBand {
  double from_rad_s = 0.0;
  double to_rad_s = 0.0;
};

/// Greatest deviation of an approximation from G over a band.
struct FrequencyDeviation {
  double gain_percent = 0.0;
  double phase_deg = 0.0;
  double relative = 0.0;  ///< |approximation / G - 1|
};

/// Frequencies over the band, so dense that ln G changes by little from one to the next.
[[nodiscard]] std::vector<double> dense_grid(const TransferFunction& g, const AngularBand& band);

/// @param frequencies_rad_s  where to compare, positive
[[nodiscard]] FrequencyDeviation deviation(const Sections& sections, const TransferFunction& g,
                                           const std::vector<double>& frequencies_rad_s);

/// A rational function near G of fractional orders: the fewest poles that keep |approximation / G - 1| below `wanted`
/// over the band, or the best of all tried. Its poles have negative real parts; a whole power of 1/s in G stays as a
/// pole at 0. The gain at s = 0 is fitted too where it is finite.
/// Fitted by vector fitting with relative weights: Gustavsen and Semlyen, IEEE Trans. Power Delivery 14 (1999).
/// @param g       passes check(), does not grow
/// @throws ConfigError  G has a pole of order 2 or more at 0
/// Cost: at most some ten thousand evaluations of G and a hundred least-squares problems of at most 1000 x 60, 0.1 s.
[[nodiscard]] Sections approximate(const TransferFunction& g, const AngularBand& band, double wanted);

}  // namespace eha::ident
