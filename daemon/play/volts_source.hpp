// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "daemon/acquisition/command_source.hpp"
#include "daemon/play/play.hpp"

namespace eha::play {

/// Makes the source of a run's volts: an experiment's table, alone, with a hold or after a start; or the way to a
/// place.
/// @param request  its spans must outlive the source
/// @throws ConfigError  as TableSource
[[nodiscard]] std::unique_ptr<acquisition::CommandSource> make_source(const PlayRequest& request);

}  // namespace eha::play
