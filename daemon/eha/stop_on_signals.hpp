// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <csignal>
#include <optional>
#include <utility>
#include <vector>

#include "daemon/acquisition/stop_request.hpp"

namespace eha::cli {

/// Role of this process.
enum class Driver {
  this_process,  ///< drives the rig: a stopped or suspended process would leave the last voltage on the output
  service,       ///< only watches: the terminal may end or suspend it as usual
};

/// While an object of this class lives, signals that end or suspend the process stop the tick loop instead: the first
/// one ramps out, the second one makes the rig safe at once. These are SIGINT and SIGTERM; in a process that drives the
/// rig also SIGHUP, SIGQUIT (Ctrl-\) and SIGTSTP (Ctrl-Z), and the terminal cannot suspend it in the background
/// (SIGTTIN, SIGTTOU). One at a time in a process.
class StopOnSignals {
 public:
  explicit StopOnSignals(Driver driver = Driver::this_process);
  StopOnSignals(const StopOnSignals&) = delete;
  StopOnSignals& operator=(const StopOnSignals&) = delete;
  ~StopOnSignals();

  [[nodiscard]] acquisition::StopRequest& request() noexcept;
  /// Returns the number of requested stops.
  [[nodiscard]] int count() const noexcept;

  /// The last one of them; none: no stop was requested.
  [[nodiscard]] std::optional<int> signal() const noexcept;

  /// Raises SIGHUP, once, where a terminal of this process is gone: the kernel sends it only to the sessions and groups
  /// that it controls, so that a command which su or setsid began would go on unseen. Called several times a second.
  void notice_lost_terminal() noexcept;

  /// Gives the signals back to what handled them before, and returns the number of stops that were requested: none is
  /// lost between the two.
  [[nodiscard]] int end() noexcept;

 private:
  void handle(int number, void (*handler)(int));
  void give_back() noexcept;

  std::vector<std::pair<int, struct sigaction>> before_;
  std::vector<int> terminals_;  ///< of standard input, output and error, those that are a terminal; none once lost
};

}  // namespace eha::cli
