// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "ident/excitation/excitation_options.hpp"

namespace eha::ident {

/// One line of a periodic table: amplitude cos(2 pi harmonic k / N + phase_rad).
struct Harmonic {
  std::size_t harmonic = 0;
  double amplitude = 0.0;
  double phase_rad = 0.0;
};

/// The lines of odd_random_multisine and gaussian for a table of so many samples, before scaling.
/// @throws ConfigError  the band holds none, or reaches the Nyquist frequency
[[nodiscard]] std::vector<Harmonic> draw_harmonics(const ExcitationOptions& options, double step_s,
                                                   std::size_t samples);

/// Their sum over one period of so many samples, each angle exact. Cost O(samples lines).
[[nodiscard]] Eigen::VectorXd sum_of(const std::vector<Harmonic>& lines, std::size_t samples);

}  // namespace eha::ident
