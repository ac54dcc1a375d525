// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <thread>

#include "daemon/control/client.hpp"

namespace eha::cli {

/// Returns the status of the service, with the rod. After a run or a reload the service needs some milliseconds for its
/// first reading; waits for it at most 1 s. @throws as Client::call
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

/// Whether the loop of the run being played has ended, and its record is being saved.
[[nodiscard]] inline bool is_over(const nlohmann::ordered_json& status) {
  const nlohmann::ordered_json& run = status.at("run");
  const std::string state = status.at("state");
  return !run.is_null() && run.value("experiment_s", 0.0) > 0.0 && (state == "idle" || state == "faulted");
}

/// Describes the state of the rig with its reason: "not armed (disarmed by meier)". An undriven rig is not armed,
/// whether the loop calls it idle or, after a start of the service, faulted; at the start of a run it is "starting".
/// @param status  of the service
[[nodiscard]] inline std::string state_text(const nlohmann::ordered_json& status) {
  constexpr const char* kStarted = "ehad has started";  // of a rig that nobody has armed yet
  std::string state = status.at("state");
  const nlohmann::ordered_json& given = status.at("reason");
  const std::string reason = given.is_string() ? given.get<std::string>() : std::string();
  if (state == "idle") state = status.at("run").is_null() || is_over(status) ? "not armed" : "starting";
  if (state == "faulted" && reason == kStarted) state = "not armed";
  if (const nlohmann::ordered_json& run = status.at("run"); !run.is_null() && run.contains("exploring_at_most_s")) {
    return fmt::format("{} (exploring: finds speeds and dead band before the triangles; at most {:.0f} min)", state,
                       run.at("exploring_at_most_s").get<double>() / 60.0);
  }
  if (reason.empty()) return state;
  // "...; run NAME" of a fault, whose run has all of it.
  constexpr std::string_view kRun = "; run ";
  const std::size_t run = reason.rfind(kRun);
  if (run == std::string::npos) return state + " (" + reason + ")";
  const std::string show = "eha runs show " + reason.substr(run + kRun.size());
  return state + " (" + reason.substr(0, run) + "; `" + show + "` says what to do)";
}

}  // namespace eha::cli
