// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "config/controller_config.hpp"
#include "core/keys.hpp"
#include "ident/control/trial.hpp"
#include "ident/excitation/excitation.hpp"

// The kinds of an experiment, with their tables in the file. For each kind there is one function in
//   experiment_config.cpp          which reads it,
//   experiment_check.cpp           which checks it against the rig and makes its table of volts,
//   daemon/play/volts_source.cpp   which makes its source of volts,
//   daemon/rig/confirmation.cpp    which says how the actuator moves,
//   daemon/record/config_json.cpp  which records it,
//   daemon/eha/run_command.cpp     which reports its completed run, and
//   daemon/eha/fit_command.cpp     which says what `eha fit` does with its record.
// A missing kind is a compiler error in each of these.

namespace eha::config {

/// Target position of [start] and [place].
struct Place {
  double displacement_in = 0.0;

  static void visit_keys(auto& self, auto& keys) { keys.number("displacement_in", self.displacement_in, Range::any()); }
};

/// [hold]: keeps an integrating rod near its predicted position.
struct Hold {
  std::optional<double> gain_V_per_in = {};  ///< correction for each inch off the prediction; none: hold_gains().usual

  static void visit_keys(auto& self, auto& keys) {
    keys.number("gain_V_per_in", self.gain_V_per_in, Range::above(0.0));
  }
};

/// [precision]: ends the run after the repetition that reaches this precision.
struct Precision {
  /// Half of the 95 % interval of the gain K, of its value [%]. K is that of integrator_lag behind the valve's map,
  /// fitted to the rows so far.
  double gain_percent = 0.0;

  static void visit_keys(auto& self, auto& keys) { keys.number("gain_percent", self.gain_percent, Range::above(0.0)); }
};

/// A controller and its trial.
struct Track {
  ControllerConfig controller;
  ident::TrialPlan plan;
  std::string controller_file = {};  ///< that the controller was read from, for suggestions; empty: not known
};

/// Plays [excitation]; models are fitted to the record. The only kind that is rehearsed.
struct Played {
  static constexpr std::string_view kCommand = "fit";  ///< of eha, which computes from the record; the same below

  ident::Excitation excitation = {};
  std::optional<Place> start = {};
  std::optional<Hold> hold = {};
  std::optional<Precision> precision = {};
};

/// Moves the rod to [place], in duration_s at most, and plays nothing.
struct Placing {
  static constexpr std::string_view kCommand = "plot";

  Place place = {};
  bool brings_back = false;            ///< also from beyond a travel limit, inward only
  std::optional<double> from_in = {};  ///< it begins here only; none: anywhere

  static void visit_keys(auto& self, auto& keys) {
    Place::visit_keys(self.place, keys);
    keys.number("from_in", self.from_in, Range::any());
    keys.boolean("way_back", self.brings_back, Need::optional);
  }
};

/// [characterise]: plays the commands that the valve sheet needs, for kSheetDuration_s.
struct SheetRun {
  static constexpr std::string_view kCommand = "characterise";

  std::optional<Place> start = {};
};

/// [track]: plays the trial of a controller, in closed loop.
struct Tracking {
  static constexpr std::string_view kCommand = "track";

  Track track = {};
  std::optional<Place> start = {};
};

using ExperimentKind = std::variant<Played, Placing, SheetRun, Tracking>;

}  // namespace eha::config
