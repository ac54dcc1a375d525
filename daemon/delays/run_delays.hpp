// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "config/rig_config.hpp"
#include "daemon/acquisition/run_report.hpp"
#include "daemon/delays/delays.hpp"

namespace eha::delays {

/// Finds possible causes of late ticks in a real-time run of this process. Not for the loop's thread.
/// @param before  read on this machine before the run
[[nodiscard]] std::vector<Delay> delays_of_run(const Counters& before, const config::RealtimeOptions& realtime,
                                               const acquisition::RunReport& report);

/// {"name", "found", "remedy"}, for run.json and `eha latency --json`.
[[nodiscard]] nlohmann::ordered_json to_json(const Delay& delay);

}  // namespace eha::delays
