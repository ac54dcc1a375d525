// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/stop_on_signals.hpp"

#include <cstddef>
#include <optional>

namespace eha::cli {
namespace {

/// A signal handler can reach nothing but what is global; made anew for each StopOnSignals.
std::optional<acquisition::StopRequest> stop_request;

void on_signal(int) { stop_request->request(); }

}  // namespace

StopOnSignals::StopOnSignals(Driver driver) {
  stop_request.emplace();
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], &action, &before_[i]);
    // nohup and background shells ignore signals on purpose.
    const bool is_left = driver == Driver::service && kSignals[i] != SIGINT && kSignals[i] != SIGTERM;
    if (before_[i].sa_handler == SIG_IGN || is_left) sigaction(kSignals[i], &before_[i], nullptr);
  }
}

StopOnSignals::~StopOnSignals() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
}

acquisition::StopRequest& StopOnSignals::request() noexcept { return *stop_request; }

int StopOnSignals::count() const noexcept { return stop_request->count(); }

}  // namespace eha::cli
