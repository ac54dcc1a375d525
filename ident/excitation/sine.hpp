// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string_view>
#include <vector>

#include "core/option_issue.hpp"
#include "ident/excitation/tone.hpp"

namespace eha::ident {

/// A cos(2 pi f t + phase).
struct Sine {
  static constexpr std::string_view kName = "sine";

  std::vector<Tone> tones;  ///< exactly one

  static void visit_keys(auto& self, auto& keys) { keys.tables("tones", self.tones); }

  [[nodiscard]] std::vector<OptionIssue> check() const;
  [[nodiscard]] Eigen::VectorXd volts(double step_s, std::size_t samples) const;
  [[nodiscard]] std::vector<double> lines_Hz(double, std::size_t) const { return frequencies_of(tones); }
  [[nodiscard]] std::vector<KeyFrequency> key_frequencies() const { return key_frequencies_of(tones); }
};

}  // namespace eha::ident
