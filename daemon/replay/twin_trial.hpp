// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "hal/sim/sim_options.hpp"
#include "ident/executor.hpp"
#include "ident/fit_options.hpp"
#include "ident/model/model.hpp"
#include "ident/structure/structure_options.hpp"

namespace eha::replay {

/// Options of the fits to simulated records, and the parameter of interest.
struct TrialTask {
  ident::StructureOptions structure;
  ident::FitOptions options;
  std::vector<ident::Model> known = {};  ///< see ident::fit()
  std::string parameter;                 ///< parameter whose standard error is computed
  double step_s = 0.001;
  int records = 6;  ///< at least 1, each with other noise
};

/// Standard errors of one parameter by fits to simulated records of one experiment. A fit that does not determine the
/// parameter counts as infinite.
struct Trial {
  /// Geometric middle of the range. A fit includes a noise model for some records and not for others, so the errors
  /// gather at both ends; a median would miss one of them.
  double std = 0.0;
  double lowest = 0.0;
  double highest = 0.0;
};

/// Plays an experiment on the twin several times and fits each record like the real one. The standard errors include
/// the model error from the twin's friction and dead band. For each record friction, oil, mass and spool are drawn
/// within 10 % of the twin's and the valve's null and dead band within 3 %, because a twin differs from its rig. A
/// parametric bootstrap; Efron and Tibshirani, An Introduction to the Bootstrap (1993), 6.5.
/// @throws ConfigError  the options make no physical sense
/// Cost: a record of 50 s takes about 0.2 s if the search is Search::known, 2 s otherwise. Deterministic for any
/// executor.
[[nodiscard]] Trial trial(const hal::SimOptions& twin, const Eigen::Ref<const Eigen::VectorXd>& volts,
                          const TrialTask& task, const ident::Executor& executor = ident::run_in_order);

}  // namespace eha::replay
