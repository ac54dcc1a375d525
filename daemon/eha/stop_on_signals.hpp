// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <csignal>
#include <utility>
#include <vector>

#include "daemon/acquisition/stop_request.hpp"

namespace eha::cli {

/// Who drives the rig.
enum class Driver {
  this_process,  ///< a stopped or suspended process would leave the last voltage on the output
  service,       ///< this one only watches: the terminal may end or suspend it as ever
};

/// While it lives, what asks a process to end or suspends it asks the loop to stop instead: the first signal ramps out,
/// the second makes the rig safe at once. SIGINT and SIGTERM; where this process drives, also SIGHUP, SIGQUIT (Ctrl-\)
/// and SIGTSTP (Ctrl-Z), and it goes on where the terminal would suspend it in the background (SIGTTIN, SIGTTOU). One
/// at a time in a process.
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
  void handle(int number, void (*handler)(int));

  std::vector<std::pair<int, struct sigaction>> before_;
};

}  // namespace eha::cli
