// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace eha::cli {

/// The result of an experiment of the queue: "completed, accepted: io, fo", "faulted", ...
[[nodiscard]] std::string verdict_text(const nlohmann::ordered_json& entry);

}  // namespace eha::cli
