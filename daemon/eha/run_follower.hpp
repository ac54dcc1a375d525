// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/display_unit.hpp"
#include "daemon/control/client.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/eha/stop_on_signals.hpp"

namespace eha::cli {

/// Follows experiments of the service's queue, one after the other, and passes Ctrl-C on to it.
class RunFollower {
 public:
  /// @param queued  all experiments of this command, in order; Ctrl-C also ends those not followed yet
  RunFollower(std::filesystem::path socket, control::Client& client, std::vector<std::int64_t> queued, DisplayUnit unit,
              Console& console);

  /// Action for an experiment that is held.
  enum class Held { wait, leave };

  /// Follows one until it is over, or held with Held::leave.
  /// @returns its last entry; none if the user did not wait for the fit
  /// @throws DeviceError  the connection is lost; gives the last known state and the command that asks again
  [[nodiscard]] std::optional<nlohmann::ordered_json> follow(std::int64_t experiment, StopOnSignals& stop, Held held);

  /// Stops the one that is driven and removes the waiting ones from the queue. @param signal  for which; none: for none
  /// @returns false if all are over
  bool pass_on_stop(std::optional<int> signal);

 private:
  using Json = nlohmann::ordered_json;

  [[nodiscard]] std::optional<Json> watch(std::int64_t experiment, StopOnSignals& stop, Held held);
  void show(std::int64_t experiment, const Json& status);
  void end_long_wait(std::int64_t experiment, const std::string& waits_for);
  [[nodiscard]] std::string last_heard(std::int64_t number) const;

  std::filesystem::path socket_;
  control::Client& client_;
  std::vector<std::int64_t> queued_;
  DisplayUnit unit_;
  Console& console_;
  Json last_ = nullptr;  ///< snapshot
  std::chrono::steady_clock::time_point last_at_;
  std::string reason_;  ///< reason for waiting, as last printed
  std::chrono::steady_clock::time_point reminded_at_ = {};
  std::optional<std::chrono::steady_clock::time_point> unarmed_since_ = {};  ///< while it is held for want of arming
  int stops_seen_ = 0;
};

}  // namespace eha::cli
