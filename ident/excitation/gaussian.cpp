// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/gaussian.hpp"

#include <cmath>

#include "ident/excitation/portable_draw.hpp"

namespace eha::ident {
namespace {

std::vector<Harmonic> draw_lines(const Gaussian& noise, double step_s, std::size_t samples) {
  const HarmonicBand band = harmonics_in(noise.band, step_s, samples);
  PortableDraw draw(noise.seed);
  std::vector<Harmonic> lines;
  for (std::size_t k = band.lowest; k <= band.highest; ++k) {
    const double in_phase = draw.normal();
    const double quadrature = draw.normal();
    lines.push_back({k, std::hypot(in_phase, quadrature), std::atan2(quadrature, in_phase)});
  }
  return lines;
}

}  // namespace

Eigen::VectorXd Gaussian::volts(double step_s, std::size_t samples) const {
  return scaled_to(amplitude_V, sum_of(draw_lines(*this, step_s, samples), samples));
}

std::vector<double> Gaussian::lines_Hz(double step_s, std::size_t samples) const {
  return frequencies_of(draw_lines(*this, step_s, samples), step_s, samples);
}

}  // namespace eha::ident
