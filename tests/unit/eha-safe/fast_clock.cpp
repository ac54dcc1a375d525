// SPDX-License-Identifier: GPL-3.0-or-later
// Loaded before the C library: the monotonic clock runs fifty times as fast, so that eha-safe gives up a card that
// never opens after 0.2 s in place of 10 s. The program itself has no way to shorten its patience.
#include <dlfcn.h>
#include <time.h>

#include <cerrno>
#include <cstdint>

namespace {

constexpr std::int64_t kTimes = 50;
constexpr std::int64_t kSecond_ns = 1'000'000'000;

template <typename F>
F next(const char* name) {
  return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}

timespec of_ns(std::int64_t ns) { return {.tv_sec = ns / kSecond_ns, .tv_nsec = ns % kSecond_ns}; }

std::int64_t to_ns(const timespec& time) { return std::int64_t{time.tv_sec} * kSecond_ns + time.tv_nsec; }

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* time) noexcept {
  static const auto real = next<decltype(&clock_gettime)>("clock_gettime");
  const int result = real(clock, time);
  if (clock == CLOCK_MONOTONIC && result == 0) *time = of_ns(to_ns(*time) * kTimes);
  return result;
}

int clock_nanosleep(clockid_t clock, int flags, const timespec* request, timespec* rest) {
  static const auto real = next<decltype(&clock_nanosleep)>("clock_nanosleep");
  if (clock != CLOCK_MONOTONIC && clock != CLOCK_REALTIME) return real(clock, flags, request, rest);
  const timespec shorter = of_ns(to_ns(*request) / kTimes);
  return real(clock, flags, &shorter, rest);
}

int nanosleep(const timespec* request, timespec* rest) {
  const int error = clock_nanosleep(CLOCK_MONOTONIC, 0, request, rest);
  if (error == 0) return 0;
  errno = error;
  return -1;
}
}
