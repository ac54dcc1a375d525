// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "core/keys.hpp"
#include "core/option_issue.hpp"
#include "ident/excitation/tone.hpp"

namespace eha::ident {

/// One line of a periodic table: amplitude cos(2 pi harmonic k / N + phase_rad).
struct Harmonic {
  std::size_t harmonic = 0;
  double amplitude = 0.0;
  double phase_rad = 0.0;
};

/// Sum of lines over one period of `samples` samples, by an inverse Fourier transform. Cost O(N log N).
/// Precondition: 2 harmonic < samples.
[[nodiscard]] Eigen::VectorXd sum_of(const std::vector<Harmonic>& lines, std::size_t samples);

/// Frequencies of lines in a table of `samples` samples [Hz].
[[nodiscard]] std::vector<double> frequencies_of(const std::vector<Harmonic>& lines, double step_s,
                                                 std::size_t samples);

/// Scales a table so that its largest absolute value is `peak`; leaves zeros alone.
[[nodiscard]] Eigen::VectorXd scaled_to(double peak, Eigen::VectorXd table);

/// A band of frequencies, two keys of several kinds [Hz].
struct FrequencyBand {
  double min_Hz = 0.0;
  double max_Hz = 0.0;

  static void visit_keys(auto& self, auto& keys) {
    keys.number("frequency_min_Hz", self.min_Hz, Range::at_least(0.0));
    keys.number("frequency_max_Hz", self.max_Hz, Range::above(0.0));
  }
  [[nodiscard]] std::vector<OptionIssue> check() const;
  [[nodiscard]] std::vector<KeyFrequency> key_frequencies() const { return {{"frequency_max_Hz", max_Hz}}; }
};

/// The harmonics of a table that lie in a band, from `lowest` to `highest`.
struct HarmonicBand {
  std::size_t lowest = 0;
  std::size_t highest = 0;
};

/// @throws ConfigError  the band holds no harmonic, or reaches the Nyquist frequency
[[nodiscard]] HarmonicBand harmonics_in(const FrequencyBand& band, double step_s, std::size_t samples);

}  // namespace eha::ident
