// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/fatal_signals.hpp"

#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstddef>

namespace eha::acquisition {
namespace {

constexpr std::array kFatal = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU};
constexpr std::size_t kSignalStack = 64 * 1024;

std::atomic<hal::Rig*> guarded_rig{nullptr};
std::atomic<StopRequest*> guarded_stop{nullptr};
std::atomic<std::int64_t> guarded_period_ns{0};
std::atomic<bool> is_dying{false};
std::array<struct sigaction, kFatal.size()> previous_actions;

thread_local bool is_loop_thread = false;

static_assert(std::atomic<hal::Rig*>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free);

/// Async-signal-safe: atomics, nanosleep, make_safe(), sigaction and raise only.
void make_safe_and_die(int signal_number) {
  is_dying = true;
  if (StopRequest* stop = guarded_stop.load()) stop->take_over_outputs();
  if (!is_loop_thread) {
    const timespec two_periods{static_cast<time_t>(2 * guarded_period_ns.load() / 1'000'000'000),
                               static_cast<long>(2 * guarded_period_ns.load() % 1'000'000'000)};
    nanosleep(&two_periods, nullptr);
  }
  if (hal::Rig* rig = guarded_rig.exchange(nullptr)) rig->make_safe();
  struct sigaction standard {};
  standard.sa_handler = SIG_DFL;
  sigaction(signal_number, &standard, nullptr);
  // Blocked while its handler runs; delivered on return, where it ends the process.
  raise(signal_number);
}

}  // namespace

FatalSignals::FatalSignals(hal::Rig& rig, StopRequest& stop, std::int64_t period_ns) {
  guarded_period_ns = period_ns;
  guarded_stop = &stop;
  guarded_rig = &rig;
  struct sigaction action {};
  action.sa_handler = make_safe_and_die;
  action.sa_flags = SA_ONSTACK;
  sigfillset(&action.sa_mask);
  for (std::size_t i = 0; i < kFatal.size(); ++i) sigaction(kFatal[i], &action, &previous_actions[i]);
}

FatalSignals::~FatalSignals() {
  for (std::size_t i = 0; i < kFatal.size(); ++i) sigaction(kFatal[i], &previous_actions[i], nullptr);
  // The loop has ended because a handler in another thread took its outputs; that handler still needs the rig.
  while (is_dying) ::pause();
  guarded_rig = nullptr;
  guarded_stop = nullptr;
}

SignalStack::SignalStack() : memory_(std::make_unique<std::byte[]>(kSignalStack)) {
  stack_t stack{};
  stack.ss_sp = memory_.get();
  stack.ss_size = kSignalStack;
  sigaltstack(&stack, nullptr);
}

SignalStack::~SignalStack() {
  stack_t off{};
  off.ss_flags = SS_DISABLE;
  sigaltstack(&off, nullptr);
}

void block_all_but_fatal_signals() noexcept {
  sigset_t blocked;
  sigfillset(&blocked);
  for (const int own : kFatal) sigdelset(&blocked, own);
  pthread_sigmask(SIG_BLOCK, &blocked, nullptr);
}

void mark_loop_thread() noexcept { is_loop_thread = true; }

}  // namespace eha::acquisition
