// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/controller_config.hpp"
#include "daemon/report/page.hpp"
#include "daemon/tune/tune_inputs.hpp"

namespace eha::tune {

/// What the page shows beside the file itself.
struct ControllerSubject {
  config::ControllerConfig controller;
  std::optional<TuneInputs> inputs = {};  ///< none: the model or the rig file is no longer there, or has changed
  std::optional<TrialTrace> trace = {};   ///< on the twin as it is
  std::vector<std::string> remarks = {};  ///< what limits it and what more would gain; of a tuning just done
};

/// The controller as one HTML page: promise, step and tracking on the twin, Bode and Nyquist plots of the open loop
/// with bands over the draws, sensitivity, settings. Cost: some 1 s, nearly all of it gnuplot's.
[[nodiscard]] report::Page controller_page(const ControllerSubject& subject);

/// Rows for people: figure, value, interval.
/// Rod beside reference, error and command of a trial.
[[nodiscard]] plot::Figure motion_figure(const TrialTrace& trace, std::string title);

[[nodiscard]] std::vector<std::vector<std::string>> promise_rows(const config::ControllerPromise& promise);

}  // namespace eha::tune
