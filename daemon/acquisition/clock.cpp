// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/clock.hpp"

#include <cerrno>
#include <ctime>

namespace eha::acquisition {

namespace {

std::int64_t read(clockid_t clock) noexcept {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<std::int64_t>(now.tv_sec) * kNanosecondsPerSecond + now.tv_nsec;
}

}  // namespace

std::int64_t MonotonicClock::now_ns() noexcept { return read(CLOCK_MONOTONIC); }

std::int64_t MonotonicClock::with_suspends_ns() noexcept { return read(CLOCK_BOOTTIME); }

void MonotonicClock::sleep_until(std::int64_t deadline_ns) noexcept {
  const timespec deadline{static_cast<time_t>(deadline_ns / kNanosecondsPerSecond),
                          static_cast<long>(deadline_ns % kNanosecondsPerSecond)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) == EINTR) {
  }
}

}  // namespace eha::acquisition
