// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <random>
#include <string>

namespace eha::test {

/// A first-order plant's answer to a slow square wave, with noise, as a record file.
/// @param seed  of the noise @param gain  of the plant, 2 as a rule @param rows  one every 40 ms
inline std::string first_order_record(int seed, double gain, int rows) {
  std::mt19937 random(static_cast<unsigned>(seed));
  std::normal_distribution<double> noise(0.0, 0.01);
  std::string text = "time_s,voltage_V,displacement_in\n";
  double y = 0.0;
  for (int k = 0; k < rows; ++k) {
    const double u = (k / 25) % 2 == 0 ? 1.0 : -0.5;
    text += std::to_string(0.04 * k) + "," + std::to_string(u) + "," + std::to_string(y + noise(random)) + "\n";
    const double decay = std::exp(-0.04 * 1.5);
    y = decay * y + (1.0 - decay) * gain / 1.5 * u;
  }
  return text;
}

}  // namespace eha::test
