// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/play/source.hpp"

#include <optional>
#include <utility>

#include "config/characterisation.hpp"
#include "config/prepared_experiment.hpp"
#include "daemon/place/centring_source.hpp"
#include "daemon/place/exploring_source.hpp"
#include "daemon/place/hold_source.hpp"
#include "daemon/place/place_source.hpp"
#include "daemon/track/track_source.hpp"

namespace eha::play {
namespace {

using acquisition::CommandSource;

place::LoopMonitor monitor_of(const PlayRequest& request) {
  return {place::loop_bounds(request.rig.limits), request.rig.realtime.sample_period_s};
}

std::unique_ptr<CommandSource> excitation_of(const PlayRequest& request) {
  const auto repetitions = static_cast<std::uint32_t>(request.experiment.repetitions);
  if (!request.experiment.hold) return std::make_unique<acquisition::TableSource>(request.table_V, repetitions);
  const double gain = request.experiment.hold->gain_V_per_in.value_or(config::hold_gains(request.rig).usual);
  return std::make_unique<place::HoldSource>(request.table_V, request.predicted_in, repetitions,
                                             config::hold_law(request.rig.limits, gain), monitor_of(request));
}

}  // namespace

std::unique_ptr<CommandSource> make_source(const PlayRequest& request) {
  const config::RigLimits& limits = request.rig.limits;
  const double step_s = request.rig.realtime.sample_period_s;
  const config::ExperimentConfig& experiment = request.experiment;
  if (experiment.place_in) {
    return std::make_unique<place::PlaceSource>(
        place::PlaceController(limits, step_s, *experiment.place_in),
        static_cast<std::uint32_t>(request.table_V.size()),
        experiment.brings_back ? place::Begin::anywhere : place::Begin::within_limits);
  }
  if (experiment.characterises) {
    const config::Centring centring = config::centring_of(limits);
    if (centring.window_in) {
      return std::make_unique<place::ExploringSource>(request.table_V, centring, limits, step_s);
    }
    return std::make_unique<place::StartingSource>(
        place::PlaceController(limits, step_s, experiment.start_in.value_or(centring.middle_in)), limits, step_s,
        std::make_unique<place::CentringSource>(request.table_V, centring, monitor_of(request), std::nullopt));
  }
  std::unique_ptr<CommandSource> excitation =
      experiment.track ? std::make_unique<track::TrackSource>(*experiment.track, limits) : excitation_of(request);
  if (!experiment.start_in) return excitation;
  // A held rod begins where its motion is about the start.
  const double ahead_in = experiment.hold ? request.predicted_in.front() : 0.0;
  return std::make_unique<place::StartingSource>(
      place::PlaceController(limits, step_s, *experiment.start_in + ahead_in), limits, step_s, std::move(excitation));
}

}  // namespace eha::play
