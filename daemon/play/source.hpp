// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "daemon/acquisition/command_source.hpp"
#include "daemon/play/play.hpp"

namespace eha::play {

/// Whether an experiment or a characterisation begins with a placing of place::kShowing_in towards mid-travel and back:
/// nothing shows that the numbers of [following] were measured on this machine, and a wrong one, or a dead sensor, is
/// found at the speed of a placing.
[[nodiscard]] bool shows_motion_first(const config::RigConfig& rig);

/// Makes the source of a run's volts: an experiment's table, alone, with a hold or after a start; or the way to a
/// place.
/// @param request  its spans must outlive the source
/// @throws ConfigError  as TableSource
[[nodiscard]] std::unique_ptr<acquisition::CommandSource> make_source(const PlayRequest& request);

}  // namespace eha::play
