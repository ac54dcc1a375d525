// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "config/rig_config.hpp"
#include "daemon/acquisition/run.hpp"
#include "daemon/acquisition/state_machine.hpp"
#include "daemon/acquisition/stop_request.hpp"
#include "daemon/ehad/queue.hpp"
#include "daemon/play/play.hpp"
#include "hal/rig.hpp"

namespace eha::service {

/// Plays a queued experiment into its run folder; blocks. The rig is idle or faulted afterwards.
/// @param rig    the card that is open; none: a simulated one is opened, so that equal experiments give equal records
/// @param machine must be armed
/// @throws as play::play
[[nodiscard]] play::FinishedRun play(const Entry& entry, const std::filesystem::path& folder,
                                     const config::RigConfig& config, hal::Rig* rig,
                                     acquisition::NonRealtime non_realtime, acquisition::StateMachine& machine,
                                     acquisition::StopRequest& stop, play::RunWatch& watch);

}  // namespace eha::service
