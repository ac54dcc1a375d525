// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "daemon/identify/source.hpp"
#include "ident/excitation/portable_draw.hpp"

namespace eha::identify::test {

/// An axis with a lag of 83 ms under nine tones.
struct MadeAxis {
  double gain = 5.0;        ///< [mm/(V s)]
  double friction_V = 0.0;  ///< dry
  double play_mm = 0.0;     ///< behind the rod, to either side
  int seed = 1;             ///< of noise and phases
};

/// 50 s of it, every 20 ms.
inline Source made_axis(const MadeAxis& of) {
  constexpr int kParts = 20;
  constexpr double kTick_s = 0.02;
  constexpr Eigen::Index kTicks = 2500;
  ident::PortableDraw draw(static_cast<std::uint64_t>(of.seed));
  Source source;
  source.name = "axis.csv";
  source.record.step_s = kTick_s;
  source.record.input.resize(kTicks);
  source.record.output.resize(kTicks);
  source.record.input_channel = {"valve", "V"};
  source.record.output_channel = {"rod", "mm"};
  double x = 0.0;
  double speed = 0.0;
  double shown = 0.0;
  for (Eigen::Index k = 0; k < kTicks; ++k) {
    double u = 0.0;
    for (int i = 1; i <= 9; ++i) {
      const double f_Hz = 0.05 * i * (i + 1) / 2.0;
      u += 0.5 * std::sin(2.0 * std::numbers::pi * f_Hz * kTick_s * static_cast<double>(k) + 0.7 * i * i + i * of.seed);
    }
    source.record.input[k] = u;
    source.record.output[k] = shown + 0.01 * draw.normal();
    for (int part = 0; part < kParts; ++part) {
      const double share = kTick_s / kParts / 0.083;
      const double pushed = speed + share * (of.gain * u - speed);
      speed = std::copysign(std::max(0.0, std::abs(pushed) - share * of.gain * of.friction_V), pushed);
      x += kTick_s / kParts * speed;
      shown = std::clamp(shown, x - of.play_mm, x + of.play_mm);
    }
  }
  return source;
}

}  // namespace eha::identify::test
