// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <csignal>

#include "daemon/acquisition/stop_request.hpp"

namespace eha::cli {

/// What the end of the terminal means.
enum class HangUp {
  stops,  ///< as SIGINT does
  ends,   ///< the process, as ever
};

/// While it lives, SIGINT, SIGTERM and SIGHUP ask the loop to stop instead of ending the process: the first one ramps
/// out, the second makes the rig safe at once. One at a time in a process.
class StopOnSignals {
 public:
  explicit StopOnSignals(HangUp hang_up = HangUp::stops);
  StopOnSignals(const StopOnSignals&) = delete;
  StopOnSignals& operator=(const StopOnSignals&) = delete;
  ~StopOnSignals();

  [[nodiscard]] acquisition::StopRequest& request() noexcept;
  /// How often a stop was asked for.
  [[nodiscard]] int count() const noexcept;

 private:
  static constexpr std::array<int, 3> kSignals{SIGINT, SIGTERM, SIGHUP};
  std::array<struct sigaction, kSignals.size()> before_{};
};

}  // namespace eha::cli
