// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace eha {

/// Decides from the loop's beats whether it has stalled. Only time between two punctual checks counts: a host that
/// takes all processors away stops the guard as well as the loop, and that is no stall. A pure function of times, so
/// that recorded times can be replayed.
class StallWatch {
 public:
  static constexpr std::int64_t kLook_ns = 5'000'000;       ///< between two checks
  static constexpr std::int64_t kPunctual_ns = 10'000'000;  ///< a longer time between two checks does not count

  /// Takes the beats found at one check. @returns the time for which they have not changed in punctual checks [ns]
  std::int64_t look(std::uint32_t drive, std::uint64_t beats, std::int64_t now_ns) noexcept {
    const std::int64_t elapsed_ns = now_ns - looked_ns_;
    looked_ns_ = now_ns;
    if (drive != drive_ || beats != beats_) {
      drive_ = drive;
      beats_ = beats;
      stalled_ns_ = 0;
    } else if (elapsed_ns <= kPunctual_ns) {
      stalled_ns_ += elapsed_ns;
    }
    return stalled_ns_;
  }

 private:
  std::uint32_t drive_ = 0;
  std::uint64_t beats_ = 0;
  std::int64_t looked_ns_ = 0;
  std::int64_t stalled_ns_ = 0;
};

}  // namespace eha
