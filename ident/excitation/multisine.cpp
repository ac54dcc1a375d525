// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/multisine.hpp"

#include <cmath>
#include <limits>
#include <optional>

#include "ident/excitation/harmonics.hpp"

namespace eha::ident {
namespace {

/// The harmonic of the table's length that equals a tone, to the rounding of the product.
std::optional<std::size_t> harmonic_of(const Tone& tone, double step_s, std::size_t samples) {
  const double cycles = tone.frequency_Hz * step_s * static_cast<double>(samples);
  const double nearest = std::round(cycles);
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * nearest;
  if (nearest < 1.0 || 2.0 * nearest >= static_cast<double>(samples) || std::abs(cycles - nearest) > rounding) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(nearest);
}

/// A Fourier transform costs about as much as the cosines of this many tones; fewer tones are summed tick by tick.
constexpr std::size_t kFewestTransformed = 8;

}  // namespace

Eigen::VectorXd Multisine::volts(double step_s, std::size_t samples) const {
  std::vector<Harmonic> harmonics;
  std::vector<Tone> others;
  for (const Tone& tone : tones) {
    if (const auto harmonic = harmonic_of(tone, step_s, samples)) {
      harmonics.push_back({*harmonic, tone.amplitude_V, tone.phase_rad});
    } else {
      others.push_back(tone);
    }
  }
  const bool transforms = harmonics.size() >= kFewestTransformed;
  Eigen::VectorXd table_V = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(samples));
  for (const Tone& tone : transforms ? others : tones) add_tone(tone, step_s, table_V);
  if (transforms) table_V += sum_of(harmonics, samples);
  return table_V;
}

}  // namespace eha::ident
