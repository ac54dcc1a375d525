// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "daemon/acquisition/command_source.hpp"
#include "daemon/play/play.hpp"

namespace eha::play {

/// What a run's volts come from: an experiment's table, alone, held or after a start; or the way to a place.
/// @param request  its spans must outlive the source
/// @throws ConfigError  as TableSource
[[nodiscard]] std::unique_ptr<acquisition::CommandSource> make_source(const PlayRequest& request);

}  // namespace eha::play
