// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <string>
#include <vector>

#include "core/keys.hpp"

namespace eha::ident {

inline constexpr double kTwoPi = 2.0 * std::numbers::pi;  ///< angle of one period [rad]

/// One cosine amplitude_V cos(2 pi frequency_Hz t + phase_rad).
struct Tone {
  double frequency_Hz = 0.0;
  double amplitude_V = 0.0;
  double phase_rad = 0.0;

  static void visit_keys(auto& self, auto& keys) {
    keys.number("frequency_Hz", self.frequency_Hz, Range::above(0.0));
    keys.number("amplitude_V", self.amplitude_V, Range::above(0.0));
    keys.number("phase_rad", self.phase_rad, Range::any(), Need::optional);
  }
};

/// Adds one tone to a table of volts, tick by tick. Cost O(table).
void add_tone(const Tone& tone, double step_s, Eigen::VectorXd& table_V);

/// Frequencies of tones, rising [Hz].
[[nodiscard]] std::vector<double> frequencies_of(const std::vector<Tone>& tones);

/// A frequency and its key below [excitation].
struct KeyFrequency {
  std::string key;
  double frequency_Hz = 0.0;
};

/// The frequency of each tone, with its key "tones[0].frequency_Hz".
[[nodiscard]] std::vector<KeyFrequency> key_frequencies_of(const std::vector<Tone>& tones);

}  // namespace eha::ident
