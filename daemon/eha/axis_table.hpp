// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/controller_config.hpp"
#include "core/display_unit.hpp"
#include "daemon/track/track_result.hpp"
#include "ident/model/model.hpp"
#include "ident/valve/valve_sheet.hpp"

namespace eha::cli {

/// An axis as one table: what it was made from, model, valve, controller, promise, and what was measured of it.
struct AxisTable {
  config::ControllerConfig controller;
  std::optional<ident::Model> model = {};  ///< none: its file is gone
  std::optional<ident::ValveSheet> sheet = {};
  std::vector<track::KeptFigure> measured = {};
};

/// CSV for spreadsheets, separated by commas: part, figure, value, from, to, measured, noise adds to, unit, kept. From
/// and to are the 95 % interval of what was measured and of margins, and the range of the trials with a quarter of it
/// more. Lengths in the unit.
[[nodiscard]] std::string axis_table(const AxisTable& table, const DisplayUnit& unit);

/// The model of a controller, where its file is as it was. @throws nothing
[[nodiscard]] std::optional<ident::Model> model_of(const config::ControllerConfig& controller);

/// The valve sheet that a controller was made with, where its run is still there. @throws nothing
[[nodiscard]] std::optional<ident::ValveSheet> sheet_of(const config::ControllerConfig& controller);

}  // namespace eha::cli
