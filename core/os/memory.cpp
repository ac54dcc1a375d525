// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/memory.hpp"

#include <malloc.h>

namespace eha::os {
namespace {

// Those of mallopt(3).
constexpr int kDefaultTrimThreshold = 128 * 1024;
constexpr int kDefaultMmapMax = 65536;

}  // namespace

void keep_freed_memory() noexcept {
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_MMAP_MAX, 0);
}

void return_freed_memory() noexcept {
  mallopt(M_TRIM_THRESHOLD, kDefaultTrimThreshold);
  mallopt(M_MMAP_MAX, kDefaultMmapMax);
}

}  // namespace eha::os
