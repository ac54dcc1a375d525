// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "ident/control/axis_design.hpp"
#include "ident/control/feedback.hpp"

namespace eha::cli {

class Console;

/// Options of a controller design from a model.
struct TuneCommand {
  std::string model_file;
  ident::AxisPurpose purpose = ident::AxisPurpose::track;
  std::optional<ident::FeedbackKind> kind = {};  ///< none: the simplest one that reaches the figures
  std::optional<double> sensitivity = {};        ///< greatest max(Ms, Mt); none: tune::usual_sensitivity()
  /// None: that of the model's run as it is now, else default_rig_file() if it is of the same rig, else as the run has
  /// it.
  std::optional<std::string> rig_file = {};
  std::optional<std::string> twin_file = {};  ///< rig file of a simulated rig
  std::optional<std::string> sheet_run = {};  ///< run of [characterise]
  std::optional<double> tick_s = {};          ///< none: the rig's
  std::filesystem::path output = "controller.toml";
};

[[nodiscard]] ExitCode execute(const TuneCommand& given, Console& console);

}  // namespace eha::cli
