// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/controller_config.hpp"
#include "core/display_unit.hpp"
#include "daemon/report/page.hpp"
#include "daemon/tune/tune_inputs.hpp"

namespace eha::tune {

/// A promised figure, measured on a rig.
struct MeasuredFigure {
  std::string name;  ///< as in promise_rows()
  double value = 0.0;
  std::string unit;
  std::string kept;    ///< "yes", "no", or why it cannot be said
  double noise = 0.0;  ///< greatest contribution of noise
  double limit = 0.0;
  bool is_least = false;        ///< the limit is a lower one: a margin
  bool is_lower_bound = false;  ///< the value, too: it is at least that
};

/// A trial on a rig.
struct MeasuredTrial {
  std::string run;
  std::vector<MeasuredFigure> figures;
  std::vector<std::string> changes;  ///< of the valve, a phrase each
  std::string advice = {};           ///< what follows from figures and changes, in sentences; empty: nothing
  bool leaks = false;                ///< the rig, by its valve sheet
  std::string by_sweep = {};         ///< gain, lag and margins that the sweep has measured, in sentences
  TrialTrace trace;
};

/// Contents of the page beside the controller's file.
struct ControllerSubject {
  config::ControllerConfig controller;
  std::optional<TuneInputs> inputs = {};  ///< none: the model or the rig file no longer exists, or has changed
  std::optional<TrialTrace> trace = {};   ///< on the undrawn twin
  std::string why_without_plots = {};     ///< names the missing or changed file, and the command to type
  std::optional<MeasuredTrial> measured = {};
  DisplayUnit unit = DisplayUnit("in");        ///< of lengths
  std::string title = {};                      ///< empty: by the controller's name
  std::string lead_html = {};                  ///< first part of the page
  std::string dated = {};                      ///< ", tried 2026-01-31 14:05 UTC", behind what it is of; empty: unknown
  std::vector<report::Section> further = {};   ///< behind the page's own, as of the run of a trial
  std::optional<suggest::RigAccess> rig = {};  ///< how the controller's file and its rig are reached; none: unknown
  std::vector<ComparedKind> kinds = {};        ///< none: the file does not store them
};

/// The controller as one HTML page: promise, step and tracking on the twin, Bode and Nyquist plots of the open loop
/// with bands over the draws, sensitivity, settings. Cost: some 1 s, nearly all of it gnuplot's.
[[nodiscard]] report::Page controller_page(const ControllerSubject& subject);

/// Draws rod and reference, error and command of a trial.
[[nodiscard]] plot::Figure motion_figure(const TrialTrace& trace, std::string title,
                                         const DisplayUnit& unit = DisplayUnit("in"));
/// Draws the first second of the trial's step.
[[nodiscard]] plot::Figure step_figure(const TrialTrace& trace, const config::ControllerConfig& controller,
                                       const DisplayUnit& unit = DisplayUnit("in"));

/// Explains the interval of each row, and the motion of the step.
[[nodiscard]] std::string promise_note(const ident::AxisSettings& settings, const DisplayUnit& unit);

/// Returns rows for display: figure, value, interval, unit.
[[nodiscard]] std::vector<std::vector<std::string>> promise_rows(const config::ControllerPromise& promise,
                                                                 const DisplayUnit& unit = DisplayUnit("in"));

/// Returns such rows for the settings: name, value, unit.
[[nodiscard]] std::vector<std::vector<std::string>> setting_rows(const config::ControllerConfig& controller,
                                                                 const DisplayUnit& unit = DisplayUnit("in"));

}  // namespace eha::tune
