// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "ident/estimation/fit_options.hpp"
#include "ident/excitation/excitation_options.hpp"

namespace eha::config {

/// A whole experiment.toml.
struct ExperimentConfig {
  std::string name;
  ident::ExcitationOptions excitation;
  double duration_s = 0.0;        ///< of one repetition [s]
  int repetitions = 1;
  ident::FitOptions fit;          ///< decimation, discarded time, split, procedure, seed
  std::vector<ident::StructureOptions> models;
  ident::AcceptanceLimits acceptance;
  std::string text;               ///< the file's content as read, for the run's manifest
};

}  // namespace eha::config
