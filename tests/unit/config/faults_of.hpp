// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "config/prepared_experiment.hpp"
#include "core/error.hpp"

namespace eha::config {

/// A rig with a slew limit of 20 V/s and the defaults otherwise.
inline RigConfig rig() {
  RigConfig rig;
  rig.file_name = "rig.toml";
  rig.limits.slew_V_per_s = 20.0;
  return rig;
}

/// What is wrong with an experiment's text on that rig; nothing where it is sound.
inline std::vector<std::string> faults_of(const std::string& text) {
  try {
    (void)parse_prepared_experiment(text, "e.toml", rig());
  } catch (const ConfigError& error) {
    return error.lines();
  }
  return {};
}

}  // namespace eha::config
