// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "config/rig_config.hpp"
#include "daemon/acquisition/run_report.hpp"
#include "daemon/delays/delays.hpp"

namespace eha::delays {

/// What can have made ticks of a run of this process late, in real time. Not for the loop's thread.
/// @param before  read on this machine before the run
[[nodiscard]] std::vector<Delay> delays_of_run(const Counters& before, const config::RealtimeOptions& realtime,
                                               const acquisition::RunReport& report);

/// {"name", "found", "remedy"}, for run.json and `eha latency --json`.
[[nodiscard]] nlohmann::ordered_json to_json(const Delay& delay);

}  // namespace eha::delays
