// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/confirmation.hpp"

#include <fmt/format.h>

#include "core/display_unit.hpp"
#include "hal/backends/backend.hpp"

namespace eha {

std::optional<std::string> confirmation_text(const config::RigConfig& rig, const config::ExperimentConfig& experiment) {
  if (!hal::moves_machine(rig.backend)) return std::nullopt;
  const DisplayUnit unit(rig.units);
  const double factor = unit.factor("in");
  if (experiment.place_in) {
    return fmt::format("This moves the actuator on {} slowly to {:.3f} {}.", hal::describe(rig.backend),
                       factor * *experiment.place_in, unit.of("in"));
  }
  if (experiment.characterises) {
    return fmt::format("This moves the actuator on {} about the middle of its travel, {:.5g}..{:.5g} {}, for {:g} s{}.",
                       hal::describe(rig.backend), factor * rig.limits.travel_min_in, factor * rig.limits.travel_max_in,
                       unit.of("in"), experiment.duration_s,
                       rig.limits.following ? "" : ", after some minutes in which the rod explores it slowly");
  }
  return fmt::format("This moves the actuator on {}: \"{}\", {:g} s, within {:g}..{:g} V.", hal::describe(rig.backend),
                     experiment.name, experiment.duration_s * experiment.repetitions, rig.limits.command_min_V,
                     rig.limits.command_max_V);
}

}  // namespace eha
