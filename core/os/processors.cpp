// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/processors.hpp"

#include <sched.h>

#include <algorithm>

namespace eha::os {

unsigned usable_processors() noexcept {
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  return sched_getaffinity(0, sizeof cpus, &cpus) == 0 ? static_cast<unsigned>(std::max(1, CPU_COUNT(&cpus))) : 1U;
}

}  // namespace eha::os
