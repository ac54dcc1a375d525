// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "daemon/acquisition/stop_request.hpp"
#include "hal/rig.hpp"

namespace eha::acquisition {

/// While this lives, a fatal signal (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU) makes the rig safe before the
/// process dies of it: takes the outputs from the loop, waits two periods for a tick under way to end unless it is the
/// loop itself that failed, calls make_safe(), and raises the signal again with its default action. The handler runs on
/// a stack of its own for the threads that have a SignalStack.
/// SIGKILL, a hung kernel and power loss reach no handler: the guard, the watchdog and the enable contactor act then.
/// One at a time in a process. Not thread-safe.
class FatalSignals {
 public:
  /// @param rig   safe to make safe from a signal handler, see Rig::make_safe; must outlive this, as must `stop`
  FatalSignals(hal::Rig& rig, StopRequest& stop, std::int64_t period_ns);
  FatalSignals(const FatalSignals&) = delete;
  FatalSignals& operator=(const FatalSignals&) = delete;
  ~FatalSignals();
};

/// While this lives, the calling thread runs the handler on a stack of its own and so survives an overflow of its
/// stack.
class SignalStack {
 public:
  SignalStack();
  SignalStack(const SignalStack&) = delete;
  SignalStack& operator=(const SignalStack&) = delete;
  ~SignalStack();

 private:
  std::unique_ptr<std::byte[]> memory_;
};

/// Lets the calling thread handle no signal but those, which a fault of its own raises. For threads that have work to
/// do while others handle signals.
void block_all_but_fatal_signals() noexcept;

/// Tells the handler that the calling thread is the loop: it need not wait for itself. Real-time safe.
void mark_loop_thread() noexcept;

}  // namespace eha::acquisition
