// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace eha::cli {

/// One line on the current run (status.run of ehad-protocol(7)): seconds, volts, inches, latency.
[[nodiscard]] std::string progress_text(const nlohmann::ordered_json& run);

/// The share of a run's experiment that has been played, 0..1.
[[nodiscard]] double share_played(const nlohmann::ordered_json& run);

/// The result of an experiment of the queue: "completed, accepted: io, fo", "faulted", ...
[[nodiscard]] std::string verdict_text(const nlohmann::ordered_json& entry);

}  // namespace eha::cli
