// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/harmonics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "core/error.hpp"
#include "ident/signal/fft.hpp"

namespace eha::ident {

Eigen::VectorXd sum_of(const std::vector<Harmonic>& lines, std::size_t samples) {
  const RealFft fft(samples);
  std::vector<std::complex<double>> spectrum(fft.bins());
  // The inverse transform adds each bin's mirror image.
  for (const Harmonic& line : lines) spectrum[line.harmonic] += std::polar(0.5 * line.amplitude, line.phase_rad);
  Eigen::VectorXd sum(static_cast<Eigen::Index>(samples));
  fft.inverse(spectrum, {sum.data(), samples});
  return sum;
}

std::vector<double> frequencies_of(const std::vector<Harmonic>& lines, double step_s, std::size_t samples) {
  const double period_s = static_cast<double>(samples) * step_s;
  std::vector<double> lines_Hz;
  for (const Harmonic& line : lines) lines_Hz.push_back(static_cast<double>(line.harmonic) / period_s);
  return lines_Hz;
}

Eigen::VectorXd scaled_to(double peak, Eigen::VectorXd table) {
  const double present = table.cwiseAbs().maxCoeff();
  if (present > 0.0) table *= peak / present;
  return table;
}

std::vector<OptionIssue> FrequencyBand::check() const {
  if (min_Hz < max_Hz) return {};
  return {{"frequency_max_Hz", fmt::format("expected more than frequency_min_Hz = {}, got {}", min_Hz, max_Hz)}};
}

HarmonicBand harmonics_in(const FrequencyBand& band, double step_s, std::size_t samples) {
  const double period_s = step_s * static_cast<double>(samples);
  // A bound written as a decimal may miss its harmonic by rounding.
  constexpr double kRounding = 1e-9;
  const double lowest = std::max(1.0, std::ceil(band.min_Hz * period_s * (1.0 - kRounding)));
  const double highest = std::floor(band.max_Hz * period_s * (1.0 + kRounding));
  if (2.0 * highest >= static_cast<double>(samples)) {
    throw ConfigError(
        fmt::format("excitation.frequency_max_Hz: expected less than the Nyquist frequency of {:.6g} Hz, got {:.6g}",
                    0.5 / step_s, band.max_Hz));
  }
  if (!(lowest <= highest)) {
    throw ConfigError(fmt::format(
        "excitation: expected a band that holds a multiple of {:.6g} Hz (1 / duration), got {:.6g}..{:.6g} Hz",
        1.0 / period_s, band.min_Hz, band.max_Hz));
  }
  return {static_cast<std::size_t>(lowest), static_cast<std::size_t>(highest)};
}

}  // namespace eha::ident
