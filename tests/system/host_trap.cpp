// SPDX-License-Identifier: GPL-3.0-or-later
// Loaded before the C library: a host whose user look-ups hang (EHA_TRAP_LOOKUP_S), one that was suspended for 100 s
// once a file is there (EHA_TRAP_SUSPENDED), and one whose disk hangs at the folder of a run and at its raw.h5 for as
// long as a file is there (EHA_TRAP_HANGS), and at its run.json while that with ".manifest" is.
#include <dlfcn.h>
#include <pwd.h>
#include <stdio.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <string>

namespace {

constexpr long kSuspended_s = 100;

template <typename F>
F next(const char* name) {
  return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}

/// @param at  "" or the ending of the file that makes it hang
void wait_for_disk(const char* at) {
  const char* file = std::getenv("EHA_TRAP_HANGS");
  const std::string name = std::string(file == nullptr ? "" : file) + at;
  while (file != nullptr && access(name.c_str(), F_OK) == 0) usleep(10'000);
}

}  // namespace

extern "C" {

int getpwuid_r(uid_t uid, passwd* entry, char* buffer, size_t size, passwd** found) {
  if (const char* seconds = std::getenv("EHA_TRAP_LOOKUP_S")) sleep(static_cast<unsigned>(std::atoi(seconds)));
  return next<decltype(&getpwuid_r)>("getpwuid_r")(uid, entry, buffer, size, found);
}

int mkdir(const char* path, mode_t mode) noexcept {
  if (std::strstr(path, "/runs/") != nullptr) wait_for_disk("");
  return next<decltype(&mkdir)>("mkdir")(path, mode);
}

int rename(const char* from, const char* to) noexcept {
  if (std::strstr(to, "raw.h5") != nullptr) wait_for_disk("");
  if (std::strstr(to, "run.json") != nullptr) wait_for_disk(".manifest");
  return next<decltype(&rename)>("rename")(from, to);
}

int clock_gettime(clockid_t clock, timespec* time) noexcept {
  static const auto real = next<decltype(&clock_gettime)>("clock_gettime");
  const int result = real(clock, time);
  if (clock != CLOCK_BOOTTIME) return result;
  const char* file = std::getenv("EHA_TRAP_SUSPENDED");
  if (file != nullptr && access(file, F_OK) == 0) time->tv_sec += kSuspended_s;
  return result;
}
}
