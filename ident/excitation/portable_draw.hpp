// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace eha::ident {

/// Random numbers that are the same with every standard library: the C++ standard fixes the generator but not the
/// distributions, which are therefore implemented here. Not thread-safe.
class PortableDraw {
 public:
  explicit PortableDraw(std::uint64_t seed) : generator_(seed) {}

  /// Uniform in [0, 1), a multiple of 2^-53.
  double uniform() { return static_cast<double>(generator_() >> 11U) * 0x1p-53; }

  /// Uniform in 0..count-1, count of at least 1. Rejects draws that would favour small numbers.
  std::uint64_t below(std::uint64_t count) {
    const std::uint64_t surplus = (std::mt19937_64::max() % count + 1) % count;
    std::uint64_t draw = generator_();
    while (draw > std::mt19937_64::max() - surplus) draw = generator_();
    return draw % count;
  }

  /// Standard normal, Box and Muller (1958).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

 private:
  std::mt19937_64 generator_;
};

}  // namespace eha::ident
