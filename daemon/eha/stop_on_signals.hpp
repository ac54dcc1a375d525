// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <csignal>

#include "daemon/acquisition/stop_request.hpp"

namespace eha::cli {

/// Who drives the rig.
enum class Driver {
  this_process,  ///< a stopped or suspended process would leave the last voltage on the output
  service,       ///< this one only watches: the terminal may end or suspend it as ever
};

/// While it lives, what asks a process to end or suspends it asks the loop to stop instead: the first signal ramps out,
/// the second makes the rig safe at once. SIGINT and SIGTERM; where this process drives, also SIGHUP, SIGQUIT (Ctrl-\),
/// SIGTSTP (Ctrl-Z), SIGTTIN and SIGTTOU. One at a time in a process.
class StopOnSignals {
 public:
  explicit StopOnSignals(Driver driver = Driver::this_process);
  StopOnSignals(const StopOnSignals&) = delete;
  StopOnSignals& operator=(const StopOnSignals&) = delete;
  ~StopOnSignals();

  [[nodiscard]] acquisition::StopRequest& request() noexcept;
  /// How often a stop was asked for.
  [[nodiscard]] int count() const noexcept;

 private:
  static constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGTTIN, SIGTTOU};
  std::array<struct sigaction, kSignals.size()> before_{};
};

}  // namespace eha::cli
