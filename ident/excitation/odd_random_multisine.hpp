// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/option_issue.hpp"
#include "ident/excitation/harmonics.hpp"
#include "ident/excitation/seed.hpp"

namespace eha::ident {

/// Odd harmonics of 1/T in the band with equal amplitudes and random phases. Of each four such lines one at random is
/// left out, to detect odd distortion. Of 32 phase draws of a single realisation the one of lowest peak is kept; those
/// of several realisations are independent. The greatest peak of the table is amplitude_V.
///
/// The table holds `realisations` of it one after the other, of the same lines and amplitudes but other phases, each
/// for `periods` periods: T is the table's length over their product. The distortion of a nonlinear plant differs
/// between realisations, noise differs between periods. The first quarter of each realisation's first
/// period fades over from the realisation before it (before the first one from the last), so that nothing jumps; that
/// period is a transient.
/// Pintelon and Schoukens, System Identification, 2nd edition, 4.3.
struct OddRandomMultisine {
  static constexpr std::string_view kName = "odd_random_multisine";
  /// With several realisations: the transient, and two that show the noise.
  static constexpr int kFewestPeriods = 3;

  double amplitude_V = 0.0;  ///< peak [V]
  FrequencyBand band;
  int realisations = 1;
  int periods = 1;  ///< of each realisation
  std::uint64_t seed = kDefaultSeed;

  static void visit_keys(auto& self, auto& keys) {
    keys.number("amplitude_V", self.amplitude_V, Range::above(0.0));
    FrequencyBand::visit_keys(self.band, keys);
    keys.integer("realisations", self.realisations, 1, 1000, Need::optional);
    keys.integer("periods", self.periods, 1, 100, Need::optional);
    keys.integer("seed", self.seed, 0, kGreatestSeed, Need::optional);
  }

  [[nodiscard]] std::vector<OptionIssue> check() const;
  [[nodiscard]] std::vector<OptionIssue> check_timing(double step_s, double duration_s) const;
  /// @throws ConfigError  the samples are no multiple of realisations x periods, or the band holds no line
  [[nodiscard]] Eigen::VectorXd volts(double step_s, std::size_t samples) const;
  [[nodiscard]] std::vector<double> lines_Hz(double step_s, std::size_t samples) const;
  [[nodiscard]] std::vector<KeyFrequency> key_frequencies() const { return band.key_frequencies(); }
};

}  // namespace eha::ident
