// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <atomic>

namespace eha::test {

/// The file that EHA_TRAP_CONTROL names, mapped by a test and by every process with the trap.
struct FileTrapControl {
  std::atomic<bool> is_armed;     ///< the journal's end is being written, or was
  std::atomic<long> count;        ///< operations since then
  std::atomic<long> kill_before;  ///< number of the operation before which the processes are killed; -1: none
  std::atomic<pid_t> service;     ///< set by ehad
};

}  // namespace eha::test
