// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/control/client.hpp"

namespace eha::cli {

/// The status of the service, with the rod. After a run or a reload the service needs some milliseconds for its first
/// reading; waits for it at most 1 s. @throws as Client::call
inline nlohmann::ordered_json status_with_rod(control::Client& client) {
  constexpr int kTries = 20;
  constexpr auto kRetry = std::chrono::milliseconds(50);
  nlohmann::ordered_json status = client.call("status");
  for (int i = 0; i < kTries && status.at("rod").is_null(); ++i) {
    std::this_thread::sleep_for(kRetry);
    status = client.call("status");
  }
  return status;
}

}  // namespace eha::cli
