// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <vector>

#include "ident/record.hpp"

namespace eha::ident {

/// Poles (stable, conjugates together) and delay of a model guessed from a record.
struct PoleGuess {
  std::vector<std::complex<double>> poles;  ///< [rad/s]
  double delay_s = 0.0;
};

/// Guesses the poles of a model of integer order without a search. A long autoregression with exogenous input gives the
/// impulse response, the singular vectors of its Hankel matrix give a realisation of the requested order, and its
/// eigenvalues give the poles. Several spacings of the samples are used, because one spacing does not resolve both fast
/// and slow poles. With a free delay the quiet beginning of the impulse response is also cut off.
/// Ho and Kalman, Regelungstechnik 14 (1966); Kung, 12th Asilomar Conf. (1978); Zhu, Control Eng. Practice 6 (1998).
/// @param rows  rows of the record that are used, from the first on
/// @param poles  1..10
/// @returns  one guess a spacing and delay; none when the record is too short. Cost O(rows) a spacing, about 10 ms at
///           1000 rows. Thread-safe.
[[nodiscard]] std::vector<PoleGuess> guess_poles(const Record& record, std::size_t rows, int poles, bool delay_free);

}  // namespace eha::ident
