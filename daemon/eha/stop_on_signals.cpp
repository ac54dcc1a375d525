// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/stop_on_signals.hpp"

#include <poll.h>
#include <unistd.h>

#include <optional>

namespace eha::cli {
namespace {

/// Global, because a signal handler has no other access to it; each StopOnSignals resets it.
std::optional<acquisition::StopRequest> stop_request;

volatile std::sig_atomic_t last_signal = 0;

void on_signal(int number) {
  last_signal = number;
  stop_request->request();
}

}  // namespace

StopOnSignals::StopOnSignals(Driver driver) {
  stop_request.emplace();
  last_signal = 0;
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (isatty(descriptor) == 1) terminals_.push_back(descriptor);
  }
  handle(SIGINT, on_signal);
  handle(SIGTERM, on_signal);
  if (driver == Driver::service) return;
  for (const int number : {SIGHUP, SIGQUIT, SIGTSTP}) handle(number, on_signal);
  // Ignored: with a handler the write that raised the signal would be repeated forever.
  for (const int number : {SIGTTIN, SIGTTOU}) handle(number, SIG_IGN);
}

void StopOnSignals::handle(int number, void (*handler)(int)) {
  struct sigaction before {};
  sigaction(number, nullptr, &before);
  // A signal that nohup or a background shell ignores stays ignored.
  if (before.sa_handler == SIG_IGN) return;
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(number, &action, nullptr);
  before_.emplace_back(number, before);
}

StopOnSignals::~StopOnSignals() { give_back(); }

void StopOnSignals::give_back() noexcept {
  for (const auto& [number, before] : before_) sigaction(number, &before, nullptr);
  before_.clear();
}

void StopOnSignals::notice_lost_terminal() noexcept {
  for (const int descriptor : terminals_) {
    pollfd terminal{.fd = descriptor, .events = 0, .revents = 0};
    if (poll(&terminal, 1, 0) != 1 || (terminal.revents & (POLLHUP | POLLERR)) == 0) continue;
    terminals_.clear();
    raise(SIGHUP);
    return;
  }
}

int StopOnSignals::end() noexcept {
  give_back();
  return count();
}

acquisition::StopRequest& StopOnSignals::request() noexcept { return *stop_request; }

std::optional<int> StopOnSignals::signal() const noexcept {
  return last_signal == 0 ? std::nullopt : std::optional<int>(last_signal);
}

int StopOnSignals::count() const noexcept { return stop_request->count(); }

}  // namespace eha::cli
