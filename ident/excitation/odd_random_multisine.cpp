// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/odd_random_multisine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/error.hpp"
#include "ident/excitation/portable_draw.hpp"

namespace eha::ident {
namespace {

/// Phase draws of a single realisation, of which the one with the lowest peak is kept; more draws gain little (crest
/// factors near 2). Several realisations take each the first draw: their mean and spread are those of random phases.
constexpr int kPhaseDraws = 32;
/// Points per period of the highest line when peaks are compared.
constexpr std::size_t kPointsPerPeriod = 8;
/// Part of a realisation's first period in which it takes over from the one before.
constexpr std::size_t kFadeDivisor = 4;

/// The samples of one period. @throws ConfigError
std::size_t period_of(const OddRandomMultisine& multisine, std::size_t samples) {
  const auto blocks = static_cast<std::size_t>(multisine.realisations) * static_cast<std::size_t>(multisine.periods);
  if (samples % blocks != 0) {
    throw ConfigError(fmt::format("excitation: expected a multiple of {} samples (realisations times periods), got {}",
                                  blocks, samples));
  }
  return samples / blocks;
}

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
        fmt::format("excitation: expected a band that holds an odd multiple of 1 / period, got {:.6g}..{:.6g} Hz",
                    multisine.band.min_Hz, multisine.band.max_Hz));
  }
  return excited;
}

/// The phases of lowest peak among the draws.
std::vector<Harmonic> draw_realisation(const std::vector<std::size_t>& excited, int draws, PortableDraw& draw) {
  const std::size_t points = kPointsPerPeriod * excited.back();
  std::vector<Harmonic> best;
  double lowest_peak = 0.0;
  for (int i = 0; i < draws; ++i) {
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

std::vector<OptionIssue> OddRandomMultisine::check() const {
  std::vector<OptionIssue> issues = band.check();
  if (realisations > 1 && periods < kFewestPeriods) {
    issues.push_back({"periods", fmt::format("expected at least {} with several realisations (the first is a "
                                             "transient, the others show the noise), got {}",
                                             kFewestPeriods, periods)});
  }
  return issues;
}

std::vector<OptionIssue> OddRandomMultisine::check_timing(double step_s, double duration_s) const {
  const auto samples = std::llround(duration_s / step_s);
  const auto blocks = static_cast<long long>(realisations) * periods;
  if (samples % blocks == 0) return {};
  return {{"periods",
           fmt::format("expected realisations x periods = {} to divide the {} ticks of duration_s", blocks, samples)}};
}

Eigen::VectorXd OddRandomMultisine::volts(double step_s, std::size_t samples) const {
  PortableDraw draw(seed);
  const std::size_t period = period_of(*this, samples);
  const std::vector<std::size_t> excited = excited_harmonics(*this, step_s, period, draw);
  std::vector<Eigen::VectorXd> realised;
  const int draws = realisations > 1 ? 1 : kPhaseDraws;
  for (int i = 0; i < realisations; ++i) realised.push_back(sum_of(draw_realisation(excited, draws, draw), period));
  Eigen::VectorXd table(static_cast<Eigen::Index>(samples));
  const auto length = static_cast<Eigen::Index>(period);
  const auto fade = static_cast<Eigen::Index>(period / kFadeDivisor);
  for (std::size_t i = 0; i < realised.size(); ++i) {
    const auto from = static_cast<Eigen::Index>(i) * periods * length;
    table.segment(from, periods * length) = realised[i].replicate(periods, 1);
    const Eigen::VectorXd& before = realised[i == 0 ? realised.size() - 1 : i - 1];
    for (Eigen::Index k = 0; realisations > 1 && k < fade; ++k) {
      const double share = 0.5 - 0.5 * std::cos(std::numbers::pi * static_cast<double>(k) / static_cast<double>(fade));
      table[from + k] = share * realised[i][k] + (1.0 - share) * before[k];
    }
  }
  return scaled_to(amplitude_V, std::move(table));
}

std::vector<double> OddRandomMultisine::lines_Hz(double step_s, std::size_t samples) const {
  PortableDraw draw(seed);
  const std::size_t period = period_of(*this, samples);
  std::vector<Harmonic> lines;
  for (const std::size_t k : excited_harmonics(*this, step_s, period, draw)) lines.push_back({k, 1.0, 0.0});
  return frequencies_of(lines, step_s, period);
}

}  // namespace eha::ident
