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

/// An axis as one table: sources, model, valve, controller, promise, and the measured figures.
struct AxisTable {
  config::ControllerConfig controller;
  std::optional<ident::Model> model = {};  ///< none: its file is gone
  std::optional<ident::ValveSheet> sheet = {};
  std::vector<track::KeptFigure> measured = {};
};

/// Writes CSV for spreadsheets, separated by commas: part, figure, value, from, to, measured, noise adds to, unit,
/// kept. From and to are the 95 % interval of measured values and of margins, otherwise the range of the trials widened
/// by a quarter. Lengths in the unit.
[[nodiscard]] std::string axis_table(const AxisTable& table, const DisplayUnit& unit);

/// Returns the model of a controller, if its file is unchanged. @throws nothing
[[nodiscard]] std::optional<ident::Model> model_of(const config::ControllerConfig& controller);

/// Returns the valve sheet that a controller was made with, if its run still exists. @throws nothing
[[nodiscard]] std::optional<ident::ValveSheet> sheet_of(const config::ControllerConfig& controller);

}  // namespace eha::cli
