// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "daemon/identify/progress.hpp"
#include "daemon/identify/rounds.hpp"
#include "daemon/identify/source.hpp"
#include "ident/fit_options.hpp"
#include "ident/model/model.hpp"

namespace eha::identify {

/// An experiment designed for one parameter, or the reason why there is none.
struct DesignedExperiment {
  std::optional<NextExperiment> next = {};
  std::string refusal = {};  ///< one clause; empty with an experiment
};

/// Designs the experiment that minimises the standard error of a model's parameter within the limits of the rig that
/// recorded the source, as long as the source's experiment but at most a minute. For a simulated rig designs are tried
/// in simulation; for others the model's residual alone predicts. If the record lacks data, returns a reason and does
/// not throw.
/// @param model  a model of the source, with standard errors   @param options  of its fit
/// Cost: on a simulated rig some forty records simulated and fitted from the model, ten seconds of one processor; else
/// a second.
[[nodiscard]] DesignedExperiment designed_experiment(const Source& source, const ident::Model& model,
                                                     const std::string& parameter, const ident::FitOptions& options,
                                                     const Progress& progress);

}  // namespace eha::identify
