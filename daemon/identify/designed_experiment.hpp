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

/// An experiment designed for one parameter, or why there is none.
struct DesignedExperiment {
  std::optional<NextExperiment> next = {};
  std::string refusal = {};  ///< one clause; empty with an experiment
};

/// Designs the experiment that makes the standard error of a model's parameter smallest within the limits of the rig
/// that recorded the source, as long as the source's experiment but at most a minute. A simulated rig tries designs
/// out; for another one the model's residual alone predicts. Returns a reason, and does not throw, if the record lacks
/// something.
/// @param model  a model of the source, with standard errors   @param options  with which it was fitted
/// Cost: on a simulated rig some forty records simulated and fitted from the model, ten seconds of one processor; else
/// a second.
[[nodiscard]] DesignedExperiment designed_experiment(const Source& source, const ident::Model& model,
                                                     const std::string& parameter, const ident::FitOptions& options,
                                                     const Progress& progress);

}  // namespace eha::identify
