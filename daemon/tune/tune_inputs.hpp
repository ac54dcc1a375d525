// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "config/controller_config.hpp"
#include "config/rig_config.hpp"
#include "daemon/sheet/run_sheet.hpp"
#include "daemon/tune/tune.hpp"
#include "ident/model/model.hpp"

namespace eha::tune {

/// Greatest max(Ms, Mt) where nobody names another: less for a rod that is held than for one that follows.
[[nodiscard]] constexpr double usual_sensitivity(ident::AxisPurpose purpose) noexcept {
  return purpose == ident::AxisPurpose::hold ? 1.2 : 1.4;
}

/// Choices for a controller beside the model and the rig file.
struct TuneChoices {
  ident::AxisPurpose purpose = ident::AxisPurpose::track;
  std::optional<ident::FeedbackKind> kind = {};
  double sensitivity = usual_sensitivity(ident::AxisPurpose::track);  ///< greatest max(Ms, Mt)
  std::optional<double> tick_s = {};                                  ///< none: the rig's
  std::optional<hal::SimOptions> twin = {};     ///< fitted to this rig; none: the rig's own if it is simulated, else
                                                ///< estimated from model and valve
  std::optional<ident::ValveSheet> sheet = {};  ///< of eha characterise
};

/// A plant and the task of its controller.
struct TuneInputs {
  ident::AxisPlant plant;
  TuneTask task;
  std::string twin;                                ///< origin of the twin, for display
  double model_gain_in_per_V_s = 0.0;              ///< extending, beyond the dead band
  std::optional<double> rig_gain_in_per_V_s = {};  ///< the same of rig_gain_of; none: not known
  std::string rig_gain_of;                         ///< "the simulated rig", "the twin" or "[following]"
  double lowest_Hz = 0.0;                          ///< of the model's usable band; 0: unknown
};

/// @throws DataError  the model's units are not V and a length, or as ident::axis_plant()
[[nodiscard]] TuneInputs tune_inputs(const ident::Model& model, const config::RigConfig& rig,
                                     const TuneChoices& choices);

/// Returns the content of a controller file.
[[nodiscard]] config::ControllerConfig controller_of(const Tuned& tuned, const TuneInputs& inputs,
                                                     config::ControllerProvenance provenance, std::string name);

}  // namespace eha::tune
