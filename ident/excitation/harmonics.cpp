// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/harmonics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "ident/excitation/portable_draw.hpp"

namespace eha::ident {
namespace {

/// Phase draws among which the one of lowest peak is kept; more gain little (crest factors near 2).
constexpr int kPhaseDraws = 32;
/// Points per period of the highest line when peaks are compared.
constexpr std::size_t kPointsPerPeriod = 8;

struct Band {
  std::size_t lowest = 0;
  std::size_t highest = 0;
};

Band harmonics_in_band(const ExcitationOptions& options, double step_s, std::size_t samples) {
  const double period_s = step_s * static_cast<double>(samples);
  // A bound written as a decimal may miss its own harmonic by a rounding.
  constexpr double kRounding = 1e-9;
  const double lowest = std::max(1.0, std::ceil(options.frequency_min_Hz * period_s * (1.0 - kRounding)));
  const double highest = std::floor(options.frequency_max_Hz * period_s * (1.0 + kRounding));
  if (2.0 * highest >= static_cast<double>(samples)) {
    throw ConfigError(
        fmt::format("excitation.frequency_max_Hz: expected less than the Nyquist frequency of {:.6g} Hz, got {:.6g}",
                    0.5 / step_s, options.frequency_max_Hz));
  }
  if (!(lowest <= highest)) {
    throw ConfigError(fmt::format(
        "excitation: expected a band that holds a multiple of {:.6g} Hz (1 / duration), got {:.6g}..{:.6g} Hz",
        1.0 / period_s, options.frequency_min_Hz, options.frequency_max_Hz));
  }
  return {static_cast<std::size_t>(lowest), static_cast<std::size_t>(highest)};
}

/// Odd harmonics of the band; of each four in a row one at random is left out.
std::vector<std::size_t> odd_lines(const Band& band, PortableDraw& draw) {
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

std::vector<Harmonic> odd_random(const ExcitationOptions& options, const Band& band, PortableDraw& draw) {
  const std::vector<std::size_t> excited = odd_lines(band, draw);
  if (excited.empty()) {
    throw ConfigError(
        fmt::format("excitation: expected a band that holds an odd multiple of 1 / duration, got {:.6g}..{:.6g} Hz",
                    options.frequency_min_Hz, options.frequency_max_Hz));
  }
  const std::size_t points = kPointsPerPeriod * excited.back();
  std::vector<Harmonic> best;
  double lowest_peak = 0.0;
  for (int trial = 0; trial < kPhaseDraws; ++trial) {
    std::vector<Harmonic> lines;
    for (const std::size_t k : excited) lines.push_back({k, 1.0, 2.0 * std::numbers::pi * draw.uniform()});
    const double peak = sum_of(lines, points).cwiseAbs().maxCoeff();
    if (best.empty() || peak < lowest_peak) {
      lowest_peak = peak;
      best = std::move(lines);
    }
  }
  return best;
}

}  // namespace

std::vector<Harmonic> draw_harmonics(const ExcitationOptions& options, double step_s, std::size_t samples) {
  const Band band = harmonics_in_band(options, step_s, samples);
  PortableDraw draw(options.seed);
  if (options.kind == ExcitationKind::odd_random_multisine) return odd_random(options, band, draw);
  std::vector<Harmonic> lines;
  for (std::size_t k = band.lowest; k <= band.highest; ++k) {
    const double in_phase = draw.normal();
    const double quadrature = draw.normal();
    lines.push_back({k, std::hypot(in_phase, quadrature), std::atan2(quadrature, in_phase)});
  }
  return lines;
}

Eigen::VectorXd sum_of(const std::vector<Harmonic>& lines, std::size_t samples) {
  const auto count = static_cast<Eigen::Index>(samples);
  Eigen::VectorXd cosine(count);
  Eigen::VectorXd sine(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(count);
    cosine(k) = std::cos(angle);
    sine(k) = std::sin(angle);
  }
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(count);
  for (const Harmonic& line : lines) {
    const double in_phase = line.amplitude * std::cos(line.phase_rad);
    const double quadrature = line.amplitude * std::sin(line.phase_rad);
    const auto stride = static_cast<Eigen::Index>(line.harmonic % samples);
    Eigen::Index turn = 0;
    for (Eigen::Index k = 0; k < count; ++k) {
      sum(k) += in_phase * cosine(turn) - quadrature * sine(turn);
      turn += stride;
      if (turn >= count) turn -= count;
    }
  }
  return sum;
}

}  // namespace eha::ident
