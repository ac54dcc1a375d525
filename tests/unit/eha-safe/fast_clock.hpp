// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>

namespace eha::testing {

/// Programs that are started in the life of this have a clock that runs fifty times as fast (fast_clock.cpp).
class FastClock {
 public:
  FastClock() { setenv("LD_PRELOAD", EHA_FAST_CLOCK, 1); }
  FastClock(const FastClock&) = delete;
  FastClock& operator=(const FastClock&) = delete;
  ~FastClock() { unsetenv("LD_PRELOAD"); }
};

}  // namespace eha::testing
