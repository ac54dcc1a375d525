// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <optional>

#include "ident/control/feedback_design.hpp"
#include "ident/fractional/transfer_function.hpp"
#include "ident/model/model.hpp"

namespace eha::ident {

/// G behind a converter that holds its input for a tick, sampled at the tick, at z = e^(j w tick):
///   sum_k H(j w + j k 2 pi / tick),  H(s) = G(s) e^(-s late) (1 - e^(-s tick)) / (s tick),  |k| <= 6.
/// The truncation error is of the size of G above 13 Nyquist frequencies.
/// @param late_s  from a reading to the command that it causes [s]
[[nodiscard]] std::complex<double> sampled_plant(const TransferFunction& g, double tick_s, double late_s,
                                                 double w_rad_s);

/// 1/G(s) = c0 + c1 s + c2 s^2 + ... about s = 0: gives the required input from the output and its derivatives.
struct InverseExpansion {
  double position = 0.0;       ///< c0
  double velocity = 0.0;       ///< c1
  double acceleration = 0.0;   ///< c2
  double error_percent = 0.0;  ///< greatest deviation of c0 + c1 s + c2 s^2 from 1/G over the band; 0: whole orders
};

/// Whole orders: the power series, delay included. Fractional orders: least squares of relative error over the band.
/// @returns none if G has no gain at 0 or c1 is not positive: this expansion then gives no feed-forward
[[nodiscard]] std::optional<InverseExpansion> inverse_expansion(const TransferFunction& g,
                                                                const FrequencyInterval& band);

}  // namespace eha::ident
