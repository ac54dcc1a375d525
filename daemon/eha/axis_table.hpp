// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/controller_config.hpp"
#include "core/display_unit.hpp"
#include "daemon/track/track_result.hpp"
#include "ident/model/model.hpp"

namespace eha::cli {

/// An axis as one table: what it was made from, model, valve, controller, promise, and what was measured of it.
struct AxisTable {
  config::ControllerConfig controller;
  std::optional<ident::Model> model = {};  ///< none: its file is gone
  std::vector<track::KeptFigure> measured = {};
};

/// CSV for spreadsheets, separated by semicolons: part; figure; value; 95 % from; to; measured; unit; kept.
/// Lengths in the unit.
[[nodiscard]] std::string axis_table(const AxisTable& table, const DisplayUnit& unit);

/// The model of a controller, where its file is as it was. @throws nothing
[[nodiscard]] std::optional<ident::Model> model_of(const config::ControllerConfig& controller);

}  // namespace eha::cli
