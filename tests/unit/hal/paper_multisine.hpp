// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <numbers>

namespace eha::hal::testing {

/// The three tones of the shipped paper experiment at tick k of 1 ms [V].
inline double paper_multisine_V(int k) {
  const double t_s = k * 1e-3;
  const double turn = 2.0 * std::numbers::pi;
  return 1.9 * std::cos(turn * 0.05 * t_s + 0.3) + 1.6 * std::cos(turn * 0.20 * t_s + 1.9) +
         1.5 * std::cos(turn * 0.65 * t_s + 4.2);
}

}  // namespace eha::hal::testing
