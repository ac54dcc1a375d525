// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "config/prepared_experiment.hpp"
#include "config/rig_config.hpp"
#include "daemon/replay/twin_trial.hpp"
#include "hal/sim/sim_options.hpp"
#include "ident/design/improvement.hpp"
#include "ident/executor.hpp"
#include "ident/model/model.hpp"

namespace eha::identify {

/// Returns the limits that a rig file sets on an excitation, at its tick.
[[nodiscard]] ident::ExcitationLimits excitation_limits(const config::RigConfig& rig);

/// Predicts the result of a designed experiment.
struct DesignPredictor {
  const ident::Model& model;
  std::string parameter;
  std::optional<hal::SimOptions> twin = {};  ///< simulates the rig; none: the model file alone predicts
  ident::Executor executor = ident::run_in_order;
  std::function<void(double share)> progress = {};  ///< called between trials, 0..1
};

/// A design and, with a twin, the results of its trials. `design.std` is the middle of their range.
struct ChosenDesign {
  ident::Improvement design;
  std::optional<replay::Trial> trial = {};
};

/// Returns the best of the designs. With a twin this is the one with the best worst trial among those whose trials
/// agree within a factor of 2.25 (among all if none agree), so that the result does not depend on the noise.
/// @throws ConfigError  as ident::improve()
/// Cost: with a twin half a minute of one processor for 50 s, at most a minute.
[[nodiscard]] ChosenDesign choose_design(const DesignPredictor& predictor, const ident::ImprovementTask& task);

/// Returns the design for a longer experiment in which its tones remain periodic: with a twin the same tones in new
/// trials, else a new design. @throws ConfigError  as ident::improve()
[[nodiscard]] ChosenDesign prolonged(const DesignPredictor& predictor, const ident::Improvement& design,
                                     const ident::ImprovementTask& longer);

/// Returns the standard error that another experiment would give for the model's structure.
/// @throws ConfigError  as ident::predicted_std()
[[nodiscard]] double predicted_by(const DesignPredictor& predictor, const config::PreparedExperiment& experiment,
                                  const ident::ImprovementTask& task);

}  // namespace eha::identify
