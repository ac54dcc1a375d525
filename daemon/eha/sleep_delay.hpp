// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <mutex>
#include <optional>
#include <string>

#include "daemon/acquisition/stop_request.hpp"
#include "daemon/rig/sleep_inhibitor.hpp"

namespace eha::cli {

enum class Suspends { are_delayed, do_not_matter };

/// Delays a suspend of the machine for as long as it lives, and ramps the run out when one is announced.
class SleepDelay {
 public:
  /// @param stop  of the run; outlives this
  SleepDelay(Suspends suspends, acquisition::StopRequest& stop);

  /// What has come up since the last call, once: a suspend, or that none can be delayed; empty: nothing.
  [[nodiscard]] std::string news();

 private:
  void tell(std::string news);

  std::mutex mutex_;
  std::string news_;
  std::optional<SleepInhibitor> inhibitor_;
};

}  // namespace eha::cli
