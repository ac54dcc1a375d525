// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string_view>
#include <vector>

#include "ident/excitation/harmonics.hpp"

namespace eha::ident {

/// A sin(2 pi (f_min t + (f_max - f_min) t^2 / (2 T))), T the table's length.
struct Chirp {
  static constexpr std::string_view kName = "chirp";

  double amplitude_V = 0.0;  ///< peak [V]
  FrequencyBand band;

  static void visit_keys(auto& self, auto& keys) {
    keys.number("amplitude_V", self.amplitude_V, Range::above(0.0));
    FrequencyBand::visit_keys(self.band, keys);
  }

  [[nodiscard]] std::vector<OptionIssue> check() const { return band.check(); }
  [[nodiscard]] Eigen::VectorXd volts(double step_s, std::size_t samples) const;
  [[nodiscard]] std::vector<KeyFrequency> key_frequencies() const { return band.key_frequencies(); }
};

}  // namespace eha::ident
