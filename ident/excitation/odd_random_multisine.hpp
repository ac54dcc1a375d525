// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "ident/excitation/harmonics.hpp"
#include "ident/excitation/seed.hpp"

namespace eha::ident {

/// Odd harmonics of 1/T in the band, T the table's length, with equal amplitudes and random phases. Of each four such
/// lines one at random is left out, to detect odd distortion. Of 32 phase draws the one of lowest peak is kept and
/// scaled to amplitude_V. Pintelon and Schoukens, System Identification, 2nd edition, 4.3.
struct OddRandomMultisine {
  static constexpr std::string_view kName = "odd_random_multisine";

  double amplitude_V = 0.0;  ///< peak [V]
  FrequencyBand band;
  std::uint64_t seed = kDefaultSeed;

  static void visit_keys(auto& self, auto& keys) {
    keys.number("amplitude_V", self.amplitude_V, Range::above(0.0));
    FrequencyBand::visit_keys(self.band, keys);
    keys.integer("seed", self.seed, 0, kGreatestSeed, Need::optional);
  }

  [[nodiscard]] std::vector<OptionIssue> check() const { return band.check(); }
  [[nodiscard]] Eigen::VectorXd volts(double step_s, std::size_t samples) const;
  [[nodiscard]] std::vector<double> lines_Hz(double step_s, std::size_t samples) const;
  [[nodiscard]] std::vector<KeyFrequency> key_frequencies() const { return band.key_frequencies(); }
};

}  // namespace eha::ident
