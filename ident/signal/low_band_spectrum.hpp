// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <cstddef>
#include <utility>
#include <vector>

#include "ident/signal/fft.hpp"

namespace eha::ident {

/// Computes the lowest bins of long Fourier transforms by transforms of a fraction of the length. Binomial filters ((1
/// + z^-1)/2)^m, undone in the spectrum, allow the signal to be thinned to every second sample several times. The
/// aliases in the wanted bins are below 1e-11 of the signal's size. Immutable, thread-safe.
/// Hogenauer, IEEE Trans. ASSP 29 (1981), for filters that are sharp where the aliases of a narrow band fall.
class LowBandSpectrum {
 public:
  /// @param length   of the transform @param samples  of a signal, zeros behind it @param bins  wanted, from 0 on
  LowBandSpectrum(std::size_t length, std::size_t samples, std::size_t bins);

  /// sum_n signal[n] exp(-2 pi i j n / length) for j = 0..bins-1. Cost O(samples), a few operations each.
  [[nodiscard]] std::vector<std::complex<double>> operator()(std::vector<double> signal) const {
    return after(0, std::move(signal));
  }

  /// The first halvings, as one filter that keeps every 2^halvings-th sample.
  struct FirstHalvings {
    std::size_t halvings = 0;
    std::vector<double> taps;
    std::size_t outputs = 0;
  };
  /// @param most  halvings that are wanted; there may be fewer. Cost O(taps^2)
  [[nodiscard]] FirstHalvings first_halvings(std::size_t most) const;
  /// The same bins, of a signal that has been through the first halvings.
  [[nodiscard]] std::vector<std::complex<double>> after(std::size_t halvings, std::vector<double> signal) const;

 private:
  std::size_t samples_;                       ///< of a signal
  std::vector<std::vector<double>> filters_;  ///< taps of each halving
  std::size_t length_;                        ///< of the remaining transform
  std::vector<std::complex<double>> undo_;    ///< one a bin
};

}  // namespace eha::ident
