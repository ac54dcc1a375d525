// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/play/volts_source.hpp"

#include <optional>
#include <utility>
#include <variant>

#include "config/characterisation.hpp"
#include "config/measured_check.hpp"
#include "config/prepared_experiment.hpp"
#include "daemon/place/centring_source.hpp"
#include "daemon/place/exploring_source.hpp"
#include "daemon/place/hold_source.hpp"
#include "daemon/place/place_source.hpp"
#include "daemon/place/pressure_source.hpp"
#include "daemon/place/showing_source.hpp"
#include "daemon/track/track_source.hpp"

namespace eha::play {
namespace {

using acquisition::CommandSource;

place::LoopMonitor monitor_of(const PlayRequest& request) {
  return {place::loop_bounds(request.rig.limits), request.rig.realtime.sample_period_s};
}

/// Moves the rod to a place, then plays `source`.
std::unique_ptr<CommandSource> started(const PlayRequest& request, double place_in,
                                       std::unique_ptr<CommandSource> source) {
  const config::RigLimits& limits = request.rig.limits;
  const double step_s = request.rig.realtime.sample_period_s;
  return std::make_unique<place::StartingSource>(place::PlaceController(limits, step_s, place_in), limits, step_s,
                                                 std::move(source));
}

/// Plays `source` once the pressure has built up. A placing waits for it by itself.
std::unique_ptr<CommandSource> under_pressure(const PlayRequest& request, std::unique_ptr<CommandSource> source) {
  const auto& following = request.rig.limits.following;
  if (!following || !(following->pressure_delay_s > 0.0)) return source;
  return std::make_unique<place::PressureSource>(*following, request.rig.realtime.sample_period_s, std::move(source));
}

/// Moves the rod a little and back before `source`, whose volts numbers choose or foretell that nobody measured.
std::unique_ptr<CommandSource> shown(const PlayRequest& request, std::unique_ptr<CommandSource> source) {
  if (!config::shows_motion_first(request.rig)) return source;
  return std::make_unique<place::ShowingSource>(request.rig.limits, request.rig.realtime.sample_period_s,
                                                std::move(source));
}

std::unique_ptr<CommandSource> table_of(const config::Played& played, const PlayRequest& request) {
  const auto repetitions = static_cast<std::uint32_t>(request.experiment.repetitions);
  if (!played.hold) return std::make_unique<acquisition::TableSource>(request.table_V, repetitions);
  const double gain = played.hold->gain_V_per_in.value_or(config::hold_gains(request.rig).usual);
  return std::make_unique<place::HoldSource>(request.table_V, request.predicted_in, repetitions,
                                             config::hold_law(request.rig.limits, gain), monitor_of(request));
}

// Makes the source of each kind.

std::unique_ptr<CommandSource> source_of(const config::Played& played, const PlayRequest& request) {
  std::unique_ptr<CommandSource> table = table_of(played, request);
  if (played.start) {
    // A held rod starts at the mean of its motion about the start.
    const double ahead_in = played.hold ? request.predicted_in.front() : 0.0;
    table = started(request, played.start->displacement_in + ahead_in, std::move(table));
  } else if (!config::shows_motion_first(request.rig)) {
    table = under_pressure(request, std::move(table));
  }
  return shown(request, std::move(table));
}

std::unique_ptr<CommandSource> source_of(const config::Placing& placing, const PlayRequest& request) {
  return std::make_unique<place::PlaceSource>(
      place::PlaceController(request.rig.limits, request.rig.realtime.sample_period_s, placing.place.displacement_in),
      static_cast<std::uint32_t>(request.table_V.size()),
      placing.brings_back ? place::Begin::anywhere : place::Begin::within_limits);
}

std::unique_ptr<CommandSource> source_of(const config::SheetRun& sheet, const PlayRequest& request) {
  const config::RigLimits& limits = request.rig.limits;
  const config::Centring centring = config::centring_of(limits);
  if (centring.window_in) {
    return std::make_unique<place::ExploringSource>(request.table_V, config::characterisation_plan(request.rig),
                                                    centring, limits, request.rig.realtime.sample_period_s);
  }
  return shown(request, started(request, sheet.start ? sheet.start->displacement_in : centring.middle_in,
                                std::make_unique<place::CentringSource>(request.table_V, centring, monitor_of(request),
                                                                        std::nullopt)));
}

std::unique_ptr<CommandSource> source_of(const config::Tracking& tracking, const PlayRequest& request) {
  auto loop = std::make_unique<track::TrackSource>(tracking.track, request.rig.limits);
  if (!tracking.start) return loop;
  return started(request, tracking.start->displacement_in, std::move(loop));
}

}  // namespace

std::unique_ptr<CommandSource> make_source(const PlayRequest& request) {
  return std::visit([&](const auto& kind) { return source_of(kind, request); }, request.experiment.kind);
}

}  // namespace eha::play
