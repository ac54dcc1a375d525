// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/display_unit.hpp"
#include "daemon/eha/commission_state.hpp"

namespace eha::cli {

/// Says that the record knows the gain less well than was wanted; empty where it does not.
/// @param record  result of that step
[[nodiscard]] std::string missed_precision(const nlohmann::ordered_json& record);

/// The report of a commissioning: verdict, the runs with links, valve, model, warnings of doctor, promised and measured
/// figures, and the controller. @param rig  its name   @param anew  command that begins another one
/// @throws DataError, IoError, PermissionError  as track::track_result
[[nodiscard]] std::string commission_page(const CommissionState& state, const std::string& rig, const std::string& anew,
                                          const DisplayUnit& unit);

}  // namespace eha::cli
