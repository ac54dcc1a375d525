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

/// What a controller is searched for and tried on.
struct TuneTask {
  ident::AxisTask axis;
  std::optional<ident::FeedbackKind> kind = {};  ///< none: the least that reaches the figures
  hal::SimOptions twin;                          ///< about which twins are drawn
  TwinSpread spread;
  int twins = 50;
  double hold_s = 60.0;
  std::uint64_t seed = 1;
  DisplayUnit unit = DisplayUnit("in");  ///< of lengths in remarks and messages
};

/// What the rod will do: figures over all drawn twins, margins over all draws of the model.
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

/// Bounds beyond which a run of the controller is a fault.
struct ControllerFault {
  double following_error_in = 0.0;  ///< size of reference less reading
  double swing_V = 0.0;             ///< of the command about its null, see ident::SwingCounter
  double swings_per_s = 0.0;        ///< more in one second
};

/// A feedback that was tried on a few twins.
struct Candidate {
  ident::FeedbackKind kind = ident::FeedbackKind::p;
  double share = 1.0;  ///< of the gain that the limits allow
  ident::AxisDesign design = {};
  double following_rms_in = 0.0;  ///< median
  double rest_error_in = 0.0;     ///< greatest
  double standing_in = 0.0;       ///< greatest
  bool hunts = false;             ///< on one of them
};

/// A kind of feedback beside the others: the best that was tried of it.
struct ComparedKind {
  ident::FeedbackKind kind = ident::FeedbackKind::p;
  std::optional<double> following_rms_in = {};  ///< none: not tried
  std::optional<double> rest_error_in = {};     ///< none: not tried
  /// RMS error after a step of load, over that of the PID; none: the error stays, or there is no PID.
  std::optional<double> load_error_of_pid = {};
  double lasting_error_s = 0.0;  ///< of a load that would move the rod at 1 in/s: 1/kp without an integral [in/(in/s)]
};

/// A controller and what it promises.
struct Tuned {
  ident::AxisDesign design = {};
  double share = 1.0;
  Promise promise;
  ControllerFault fault;
  ident::TrialPlan plan;
  std::vector<ident::TrialFigures> trials;  ///< one a twin
  std::vector<Candidate> candidates;        ///< in the order of their trial
  std::vector<ComparedKind> kinds;          ///< those that do not hunt, and FOPID where it was compared
  std::vector<std::string> remarks;         ///< what limits it, and what more would have gained; a sentence each
  TrialTrace trace;                         ///< on the twin itself
};

/// Peak to peak of a rod at rest from which on it hunts: three standard deviations of the readings and one LSB.
[[nodiscard]] double most_standing_in(const ident::AxisTask& task);

/// Designs feedback of each kind that is asked for, tries it with less and less gain on a few twins, then the best on
/// all of them. One that hunts on any twin is not offered: the next takes its place.
/// @throws DataError  nothing keeps the limits, or every candidate hunts; says what limits
/// Cost: about 80 s of simulated time a twin; 50 twins some 4 s of one processor. Deterministic, whatever the executor.
[[nodiscard]] Tuned tune(const ident::AxisPlant& plant, const TuneTask& task,
                         const ident::Executor& executor = ident::run_in_order);

}  // namespace eha::tune
