// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/controller_config.hpp"
#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"
#include "daemon/suggest/commands.hpp"
#include "daemon/tune/expected_trip.hpp"
#include "daemon/tune/tune_inputs.hpp"
#include "ident/model/model.hpp"

// What a new controller is of, and what to do with it.

namespace eha::cli {

struct TuneCommand;

/// The trial that `eha track --local` plays of a controller on a simulated rig, whose tick it takes; none if it
/// refuses.
[[nodiscard]] std::optional<config::Track> trial_on(const config::RigConfig& rig,
                                                    const config::ControllerConfig& controller);

/// Returns what to do with a controller: its trial on the machine's or the service's terms, on a simulated rig that
/// takes it, the model's own first; else the way to a twin that does. A trial that trips is not offered.
/// @param access  to the rig   @param page  of the controller
[[nodiscard]] std::vector<std::string> next_steps(const TuneCommand& command, const ident::Model& model,
                                                  const config::RigConfig& rig,
                                                  const config::ControllerConfig& controller,
                                                  const suggest::RigAccess& access,
                                                  const std::optional<tune::ExpectedTrip>& trip,
                                                  const std::optional<std::string>& valve_first, bool is_of_before,
                                                  const std::filesystem::path& page);

/// What a promise is of, for the first lines of the answer: the plant, and what of model and plant does not agree.
/// @throws DataError  the plant is a rig that nothing shows to be the model's, and it is another one
[[nodiscard]] std::vector<std::string> plant_sentences(const TuneCommand& command, const ident::Model& model,
                                                       const config::RigConfig& rig, const tune::TuneInputs& inputs,
                                                       const std::filesystem::path& rig_file);

}  // namespace eha::cli
