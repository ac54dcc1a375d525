// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace eha::cli {

/// The result of an experiment of the queue: "completed, accepted: io, fo", "faulted", ...
[[nodiscard]] std::string verdict_text(const nlohmann::ordered_json& entry);

/// When the experiments of a queue end by the clock, "15:44" in local time, one text an entry: of the one that is
/// played by the time in its run's name, of those that wait behind it one after the other, arming and fits left out.
/// Empty for others, in virtual time, and where nothing is played.
[[nodiscard]] std::vector<std::string> end_times(const nlohmann::ordered_json& entries);

}  // namespace eha::cli
