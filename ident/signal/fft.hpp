// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace eha::ident {

/// Smallest length of at least `minimum` that is a multiple of `divisor` and whose quotient by it is even and has no
/// prime factor above 5, so that a Fourier transform of it is fast.
[[nodiscard]] std::size_t fast_length(std::size_t minimum, std::size_t divisor = 1);

/// Discrete Fourier transform of real signals of one length by FFTW. Plans are estimated, never measured, so that
/// results repeat bit for bit. Thread-safe. The first object of a length costs about a millisecond, a transform O(L log
/// L).
class RealFft {
 public:
  explicit RealFft(std::size_t length);
  [[nodiscard]] std::size_t length() const noexcept { return length_; }
  [[nodiscard]] std::size_t bins() const noexcept { return length_ / 2 + 1; }

  /// X_j = sum_n x_n exp(-2 pi i j n / L), j = 0..L/2. @param signal L samples @param spectrum L/2+1 bins
  void forward(std::span<const double> signal, std::span<std::complex<double>> spectrum) const;

  /// x_n = sum_j X_j exp(2 pi i j n / L) over all L bins of a Hermitian spectrum, not divided by L. Destroys spectrum.
  void inverse(std::span<std::complex<double>> spectrum, std::span<double> signal) const;

 private:
  struct Plans;
  std::size_t length_;
  std::shared_ptr<const Plans> plans_;
};

}  // namespace eha::ident
