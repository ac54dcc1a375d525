// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "config/characterisation.hpp"
#include "config/rig_config.hpp"
#include "daemon/acquisition/following_monitor.hpp"
#include "daemon/place/centring_source.hpp"
#include "daemon/place/exploring_source.hpp"
#include "daemon/place/place_source.hpp"
#include "hal/sim/sim_rig.hpp"
#include "ident/valve/valve_sheet.hpp"

namespace eha::place {

/// A simulated rig's record of a characterisation, and where the rod went.
struct CharacterisedRig {
  ident::Record record;
  double lowest_in = 1e9;
  double highest_in = -1e9;
  double taken_s = 0.0;  ///< the way to the middle included
  bool is_in_place = true;
  bool trips_following = false;  ///< the following check would have stopped it
};

/// Plays a characterisation tick by tick as the loop does, range and slew limit included; without its checks and files,
/// so that hundreds take a minute.
inline CharacterisedRig characterised(const config::RigConfig& rig, const hal::SimOptions& options) {
  const ident::SheetPlan plan = config::characterisation_plan(rig);
  const config::RigLimits& limits = rig.limits;
  const double step_s = rig.realtime.sample_period_s;
  const config::Centring centring = config::centring_of(limits);
  const std::span<const double> table_V(plan.table_V.data(), static_cast<std::size_t>(plan.table_V.size()));
  std::unique_ptr<acquisition::CommandSource> source;
  if (centring.window_in) {
    source = std::make_unique<ExploringSource>(table_V, plan, centring, limits, step_s);
  } else {
    source = std::make_unique<StartingSource>(
        PlaceController(limits, step_s, centring.middle_in), limits, step_s,
        std::make_unique<CentringSource>(table_V, centring, LoopMonitor(loop_bounds(limits), step_s), std::nullopt));
  }
  const std::unique_ptr<hal::Rig> plant = hal::open_rig(options, 0.0);
  hal::AppliedCommand applied;
  hal::RigReading reading;
  plant->set_enable(true);
  plant->command(0.0, applied);
  CharacterisedRig played;
  played.record.step_s = step_s;
  played.record.input.resize(plan.table_V.size());
  played.record.output.resize(plan.table_V.size());
  acquisition::FollowingMonitor following(acquisition::following_rule(limits));
  following.begin(0);
  std::int64_t tick = 0;
  double command_V = 0.0;
  const double most_V = limits.slew_V_per_s * step_s;
  const auto play = [&](std::uint32_t row) {
    const std::int64_t at_ns = tick++ * std::llround(step_s * 1e9);
    plant->read(at_ns, reading);
    if (following.check(at_ns, reading.displacement_in, command_V).fault != acquisition::Fault::none) {
      played.trips_following = true;
    }
    const double wanted_V = std::clamp(source->voltage_V(row, reading), limits.command_min_V, limits.command_max_V);
    command_V += std::clamp(wanted_V - command_V, -most_V, most_V);
    plant->command(command_V, applied);
    played.lowest_in = std::min(played.lowest_in, reading.displacement_in);
    played.highest_in = std::max(played.highest_in, reading.displacement_in);
  };
  while (source->stage() == acquisition::CommandSource::Stage::preparing && played.is_in_place) {
    play(0);
    played.is_in_place = source->breach().fault == acquisition::Fault::none;
  }
  for (Eigen::Index k = 0; k < plan.table_V.size() && played.is_in_place; ++k) {
    play(static_cast<std::uint32_t>(k));
    if (source->breach().fault != acquisition::Fault::none) played.trips_following = true;
    played.record.output[k] = reading.displacement_in;
    played.record.input[k] = applied.applied_V;
  }
  played.taken_s = static_cast<double>(tick) * step_s;
  return played;
}

}  // namespace eha::place
