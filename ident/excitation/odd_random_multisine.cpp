// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/odd_random_multisine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <utility>

#include "core/error.hpp"
#include "ident/excitation/portable_draw.hpp"

namespace eha::ident {
namespace {

/// Phase draws, of which the one with the lowest peak is kept; more draws gain little (crest factors near 2).
constexpr int kPhaseDraws = 32;
/// Points per period of the highest line when peaks are compared.
constexpr std::size_t kPointsPerPeriod = 8;

/// Odd harmonics of the band; of each four in a row one at random is left out.
std::vector<std::size_t> draw_odd_harmonics(const HarmonicBand& band, PortableDraw& draw) {
  constexpr std::size_t kGroup = 4;
  std::vector<std::size_t> odd;
  for (std::size_t k = band.lowest | 1U; k <= band.highest; k += 2) odd.push_back(k);
  std::vector<std::size_t> excited;
  for (std::size_t start = 0; start < odd.size(); start += kGroup) {
    const std::size_t size = std::min(kGroup, odd.size() - start);
    const std::size_t silent = size == kGroup ? draw.below(kGroup) : kGroup;
    for (std::size_t i = 0; i < size; ++i) {
      if (i != silent) excited.push_back(odd[start + i]);
    }
  }
  return excited;
}

/// Draws the excited harmonics; the same generator then draws the phases.
std::vector<std::size_t> excited_harmonics(const OddRandomMultisine& multisine, double step_s, std::size_t samples,
                                           PortableDraw& draw) {
  std::vector<std::size_t> excited = draw_odd_harmonics(harmonics_in(multisine.band, step_s, samples), draw);
  if (excited.empty()) {
    throw ConfigError(
        fmt::format("excitation: expected a band that holds an odd multiple of 1 / duration, got {:.6g}..{:.6g} Hz",
                    multisine.band.min_Hz, multisine.band.max_Hz));
  }
  return excited;
}

}  // namespace

Eigen::VectorXd OddRandomMultisine::volts(double step_s, std::size_t samples) const {
  PortableDraw draw(seed);
  const std::vector<std::size_t> excited = excited_harmonics(*this, step_s, samples, draw);
  const std::size_t points = kPointsPerPeriod * excited.back();
  std::vector<Harmonic> best;
  double lowest_peak = 0.0;
  for (int i = 0; i < kPhaseDraws; ++i) {
    std::vector<Harmonic> lines;
    for (const std::size_t k : excited) lines.push_back({k, 1.0, 2.0 * std::numbers::pi * draw.uniform()});
    const double peak = sum_of(lines, points).cwiseAbs().maxCoeff();
    if (best.empty() || peak < lowest_peak) {
      lowest_peak = peak;
      best = std::move(lines);
    }
  }
  return scaled_to(amplitude_V, sum_of(best, samples));
}

std::vector<double> OddRandomMultisine::lines_Hz(double step_s, std::size_t samples) const {
  PortableDraw draw(seed);
  std::vector<Harmonic> lines;
  for (const std::size_t k : excited_harmonics(*this, step_s, samples, draw)) lines.push_back({k, 1.0, 0.0});
  return frequencies_of(lines, step_s, samples);
}

}  // namespace eha::ident
