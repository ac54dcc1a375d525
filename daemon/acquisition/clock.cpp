// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/clock.hpp"

#include <cerrno>
#include <ctime>

namespace eha::acquisition {

std::int64_t MonotonicClock::now_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * kNanosecondsPerSecond + now.tv_nsec;
}

void MonotonicClock::sleep_until(std::int64_t deadline_ns) noexcept {
  const timespec deadline{static_cast<time_t>(deadline_ns / kNanosecondsPerSecond),
                          static_cast<long>(deadline_ns % kNanosecondsPerSecond)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) == EINTR) {
  }
}

}  // namespace eha::acquisition
