// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "daemon/acquisition/stop_request.hpp"
#include "hal/rig.hpp"

namespace eha::acquisition {

/// While this lives, a fatal signal (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU) makes the rig safe before the
/// process dies of it: takes the outputs from the loop, waits two periods for the present tick to end unless the loop
/// itself failed, calls make_safe(), and raises the signal again with its default action. The handler runs on a stack
/// of its own for the threads that have a SignalStack.
/// SIGKILL, a hung kernel and power loss reach no handler; the guard, the watchdog and the enable contactor cover them.
/// One at a time in a process. Not thread-safe.
class FatalSignals {
 public:
  /// @param rig   its make_safe() is called from a signal handler; must outlive this, as must `stop`
  FatalSignals(hal::Rig& rig, StopRequest& stop, std::int64_t period_ns);
  FatalSignals(const FatalSignals&) = delete;
  FatalSignals& operator=(const FatalSignals&) = delete;
  ~FatalSignals();
};

/// While this lives, the calling thread runs the handler on its own stack, and so survives an overflow of its stack.
class SignalStack {
 public:
  SignalStack();
  SignalStack(const SignalStack&) = delete;
  SignalStack& operator=(const SignalStack&) = delete;
  ~SignalStack();

 private:
  std::unique_ptr<std::byte[]> memory_;
};

/// Blocks all signals in the calling thread except the fatal ones, which its own faults raise. For worker threads,
/// while other threads handle signals.
void block_all_but_fatal_signals() noexcept;

/// Marks the calling thread as the loop, so that the handler does not wait for itself. Real-time safe.
void mark_loop_thread() noexcept;

}  // namespace eha::acquisition
