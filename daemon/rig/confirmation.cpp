// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/confirmation.hpp"

#include <fmt/format.h>

#include <string>
#include <variant>

#include "core/display_unit.hpp"
#include "hal/backends/backend.hpp"

namespace eha {
namespace {

std::string within_volts(const config::ExperimentConfig& experiment, const config::RigConfig& rig) {
  return fmt::format(": \"{}\", {:g} s, within {:g}..{:g} V", experiment.name,
                     experiment.duration_s * experiment.repetitions, rig.limits.command_min_V,
                     rig.limits.command_max_V);
}

// Describes the motion of the actuator for each kind.

std::string motion_of(const config::Played&, const config::ExperimentConfig& experiment, const config::RigConfig& rig) {
  return within_volts(experiment, rig);
}

std::string motion_of(const config::Tracking&, const config::ExperimentConfig& experiment,
                      const config::RigConfig& rig) {
  return within_volts(experiment, rig);
}

std::string motion_of(const config::Placing& placing, const config::ExperimentConfig&, const config::RigConfig& rig) {
  const DisplayUnit unit(rig.units);
  return fmt::format(" slowly to {:.3f} {}", unit.factor("in") * placing.place.displacement_in, unit.of("in"));
}

std::string motion_of(const config::SheetRun&, const config::ExperimentConfig& experiment,
                      const config::RigConfig& rig) {
  const DisplayUnit unit(rig.units);
  const double factor = unit.factor("in");
  return fmt::format(" about the middle of its travel, {:.5g}..{:.5g} {}, for {:g} s{}",
                     factor * rig.limits.travel_min_in, factor * rig.limits.travel_max_in, unit.of("in"),
                     experiment.duration_s,
                     rig.limits.following ? "" : ", after some minutes in which the rod explores it slowly");
}

}  // namespace

std::optional<std::string> confirmation_text(const config::RigConfig& rig, const config::ExperimentConfig& experiment) {
  if (!hal::moves_machine(rig.backend)) return std::nullopt;
  const std::string motion =
      std::visit([&](const auto& kind) { return motion_of(kind, experiment, rig); }, experiment.kind);
  return fmt::format("This moves the actuator on {}{}.", hal::describe(rig.backend), motion);
}

}  // namespace eha
