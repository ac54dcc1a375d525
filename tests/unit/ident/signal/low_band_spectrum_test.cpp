// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/low_band_spectrum.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <vector>

#include "ident/excitation/portable_draw.hpp"

namespace eha::ident {
namespace {

TEST(LowBandSpectrum, EqualsTheLowestBinsOfTheWholeTransform) {
  struct Case {
    std::size_t length, samples, bins;
  };
  // A narrow band, a wide one, one that allows no halving, a short signal, an odd length.
  for (const Case& c : {Case{8000, 5000, 150}, Case{8000, 4999, 1000}, Case{8000, 5000, 4001}, Case{800, 3, 20},
                        Case{7875, 5000, 100}}) {
    PortableDraw draw(5);
    std::vector<double> signal(c.samples);
    for (double& x : signal) x = draw.normal();
    std::vector<double> padded = signal;
    padded.resize(c.length, 0.0);
    std::vector<std::complex<double>> whole(c.length / 2 + 1);
    RealFft(c.length).forward(padded, whole);
    const auto low = LowBandSpectrum(c.length, c.samples, c.bins)(signal);
    ASSERT_EQ(low.size(), c.bins);
    for (std::size_t j = 0; j < c.bins; ++j) {
      EXPECT_LT(std::abs(low[j] - whole[j]), 2e-10 * std::sqrt(static_cast<double>(c.samples)))
          << c.length << " points, bin " << j << " of " << c.bins;
    }
  }
}

}  // namespace
}  // namespace eha::ident
