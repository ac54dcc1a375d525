// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/tone.hpp"

#include <algorithm>
#include <cmath>

namespace eha::ident {

void add_tone(const Tone& tone, double step_s, Eigen::VectorXd& table_V) {
  for (Eigen::Index k = 0; k < table_V.size(); ++k) {
    const double time_s = static_cast<double>(k) * step_s;
    table_V(k) += tone.amplitude_V * std::cos(kTwoPi * tone.frequency_Hz * time_s + tone.phase_rad);
  }
}

std::vector<double> frequencies_of(const std::vector<Tone>& tones) {
  std::vector<double> lines_Hz;
  for (const Tone& tone : tones) lines_Hz.push_back(tone.frequency_Hz);
  std::sort(lines_Hz.begin(), lines_Hz.end());
  return lines_Hz;
}

std::vector<KeyFrequency> key_frequencies_of(const std::vector<Tone>& tones) {
  std::vector<KeyFrequency> list;
  for (std::size_t i = 0; i < tones.size(); ++i) {
    list.push_back({"tones[" + std::to_string(i) + "].frequency_Hz", tones[i].frequency_Hz});
  }
  return list;
}

}  // namespace eha::ident
