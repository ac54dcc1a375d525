// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>

#include "daemon/acquisition/run.hpp"

namespace eha::record {

/// The end of a run of the tick loop, with counters and histograms: the member `report` of run.json.
/// @param unit  of lengths in its sentence; numbers stay in inches
[[nodiscard]] nlohmann::ordered_json describe_report(const acquisition::RunReport& report,
                                                     const DisplayUnit& unit = {});

/// The end of the journal: outcome, fault and the main counters.
[[nodiscard]] nlohmann::ordered_json describe_end(const acquisition::RunReport& report);

}  // namespace eha::record
