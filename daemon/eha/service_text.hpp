// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace eha::cli {

/// What ehad says of a run that is on (status.run, ehad-protocol(7)), in a few words: seconds, volts, inches, latency.
[[nodiscard]] std::string progress_text(const nlohmann::ordered_json& run);

/// How much of a run's experiment is played, 0..1.
[[nodiscard]] double share_played(const nlohmann::ordered_json& run);

/// What came of an experiment of the queue: "completed, accepted: io, fo", "faulted", ...
[[nodiscard]] std::string verdict_text(const nlohmann::ordered_json& entry);

}  // namespace eha::cli
