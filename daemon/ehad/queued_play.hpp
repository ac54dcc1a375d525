// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>

#include "config/prepared_experiment.hpp"
#include "config/rig_config.hpp"
#include "daemon/acquisition/earlier_runs.hpp"
#include "daemon/acquisition/run.hpp"
#include "daemon/acquisition/state_machine.hpp"
#include "daemon/acquisition/stop_request.hpp"
#include "daemon/ehad/queue.hpp"
#include "daemon/play/play.hpp"
#include "daemon/rig/motion_at_rest.hpp"
#include "daemon/rig/owned_rig.hpp"

namespace eha::service {

/// Plays a queued experiment into its run folder; blocks. The rig is idle or faulted afterwards.
/// @param prepared  the experiment of the entry: its volts take seconds, in which somebody must read the lines
/// @param card     the open card; none: opens a simulated rig, so that equal experiments give equal records
/// @param snapshot  the page of a simulated rig is beside it, see OwnedRig
/// @param machine must be armed
/// @param rest     where the card's rod was when it was last read: nothing is driven if it moved; none: not known
/// @param earlier  the runs before on this card, then this one, too
/// @throws as play::play
[[nodiscard]] play::FinishedRun play(const Entry& entry, const config::PreparedExperiment& prepared,
                                     const std::filesystem::path& folder, const config::RigConfig& config,
                                     OwnedRig* card, const std::optional<RodAtRest>& rest,
                                     const std::filesystem::path& snapshot, acquisition::NonRealtime non_realtime,
                                     acquisition::StateMachine& machine, acquisition::EarlierRuns& earlier,
                                     acquisition::StopRequest& stop, play::RunWatch& watch);

}  // namespace eha::service
