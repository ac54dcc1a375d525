// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/display_unit.hpp"
#include "daemon/tune/axis_trial.hpp"
#include "daemon/tune/twin_draws.hpp"
#include "hal/sim/sim_options.hpp"
#include "ident/control/axis_design.hpp"
#include "ident/executor.hpp"

namespace eha::tune {

/// Where a valve that replaces the model's map is from.
enum class ValveOrigin { sheet, following };

/// Task of a controller search and of its trials.
struct TuneTask {
  ident::AxisTask axis;
  ValveOrigin valve_of = ValveOrigin::sheet;     ///< axis.valve
  bool is_one_valve = true;                      ///< the model's map is of axis.valve, given what is known of it
  std::optional<ident::FeedbackKind> kind = {};  ///< none: the simplest one that reaches the figures
  hal::SimOptions twin;                          ///< centre of the drawn twins
  TwinSpread spread;
  int twins = 50;
  double hold_s = 60.0;
  std::uint64_t seed = 1;
  DisplayUnit unit = DisplayUnit("in");  ///< of lengths in remarks and messages
};

/// Promised behaviour of the rod: figures over all drawn twins, margins over all draws of the model.
struct Promise {
  ident::Interval following_rms_in;
  ident::Interval following_worst_in;
  ident::Interval sine_rms_in;
  ident::Interval overshoot_in;
  ident::Interval settling_s;
  ident::Interval rest_error_in;
  ident::Interval standing_in;
  ident::Interval ms;
  ident::Interval mt;
  ident::Interval phase_margin_deg;
  ident::Interval gain_margin;
  ident::Interval delay_margin_s;
};

/// Bounds whose violation in a run of the controller is a fault.
struct ControllerFault {
  double following_error_in = 0.0;  ///< absolute difference of reference and reading
  double swing_V = 0.0;             ///< of the command about its null, see ident::SwingCounter
  double swings_per_s = 0.0;        ///< most swings in one second
};

/// A feedback tried on a few twins.
struct Candidate {
  ident::FeedbackKind kind = ident::FeedbackKind::p;
  double share = 1.0;  ///< of the gain that the limits allow
  ident::AxisDesign design = {};
  double following_rms_in = 0.0;  ///< median
  double rest_error_in = 0.0;     ///< greatest
  double standing_in = 0.0;       ///< greatest
  bool hunts = false;             ///< on at least one of them
};

/// The best tried feedback of a kind, for a comparison of kinds.
struct ComparedKind {
  ident::FeedbackKind kind = ident::FeedbackKind::p;
  std::optional<double> following_rms_in = {};  ///< none: not tried
  std::optional<double> rest_error_in = {};     ///< none: not tried
  /// RMS error after a load step, over that of the PID; none: the error remains, or there is no PID.
  std::optional<double> load_error_of_pid = {};
  double lasting_error_s = 0.0;  ///< for a load that would move the rod at 1 in/s: 1/kp without an integral [in/(in/s)]
};

/// A controller and its promise.
struct Tuned {
  ident::AxisDesign design = {};
  double share = 1.0;
  Promise promise;
  ControllerFault fault;
  ident::TrialPlan plan;
  std::vector<ident::TrialFigures> trials;  ///< one a twin
  std::vector<Candidate> candidates;        ///< in the order of their trial
  std::vector<ComparedKind> kinds;          ///< those that do not hunt, and FOPID if it was compared
  std::vector<std::string> remarks;         ///< limiting factors, and possible improvements; a sentence each
  TrialTrace trace;                         ///< on the twin itself
};

/// Returns the peak to peak of a rod at rest above which it hunts: three standard deviations of the readings and one
/// LSB.
[[nodiscard]] double most_standing_in(const ident::AxisTask& task);

/// Designs feedback of each requested kind, tries it with decreasing gain on a few twins, then tries the best on all of
/// them. Rejects one that hunts on any twin and takes the next.
/// @throws DataError  no feedback keeps the limits, or every candidate hunts; names the limiting factor
/// Cost: about 80 s of simulated time a twin; 50 twins some 4 s of one processor. Deterministic for any executor.
[[nodiscard]] Tuned tune(const ident::AxisPlant& plant, const TuneTask& task,
                         const ident::Executor& executor = ident::run_in_order);

}  // namespace eha::tune
