// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string_view>
#include <vector>

#include "ident/excitation/tone.hpp"

namespace eha::ident {

/// sum_i A_i cos(2 pi f_i t + phase_i).
struct Multisine {
  static constexpr std::string_view kName = "multisine";

  std::vector<Tone> tones;

  static void visit_keys(auto& self, auto& keys) { keys.tables("tones", self.tones); }

  /// Eight or more tones that are harmonics of the table's length are summed by an inverse Fourier transform, O(N log
  /// N) for all of them. Each other tone costs O(N).
  [[nodiscard]] Eigen::VectorXd volts(double step_s, std::size_t samples) const;
  [[nodiscard]] std::vector<double> lines_Hz(double, std::size_t) const { return frequencies_of(tones); }
  [[nodiscard]] std::vector<KeyFrequency> key_frequencies() const { return key_frequencies_of(tones); }
};

}  // namespace eha::ident
