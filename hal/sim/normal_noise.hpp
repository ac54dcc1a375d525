// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace eha::hal {

/// Independent, nearly Gaussian numbers of mean 0 and standard deviation 1, equal on every machine for one seed: the
/// sum of twelve uniform numbers less 6 (Irwin-Hall), drawn from SplitMix64 (Steele, Lea, Flood 2014). Uses integers up
/// to the last division, so no mathematical library affects the result. The tails end at +-6. Real-time safe.
class NormalNoise {
 public:
  explicit NormalNoise(std::uint64_t seed) noexcept : state_(seed) {}

  double operator()() noexcept {
    std::int64_t sum = 0;
    for (int word = 0; word < 3; ++word) {
      std::uint64_t bits = next();
      for (int part = 0; part < 4; ++part, bits >>= 16) sum += static_cast<std::int64_t>(bits & 0xffff);
    }
    // Each part is uniform on 0 .. 65535, mean 65535 / 2.
    return static_cast<double>(sum - std::int64_t{6} * 65535) / 65536.0;
  }

 private:
  std::uint64_t next() noexcept {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15U);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
  }

  std::uint64_t state_;
};

}  // namespace eha::hal
