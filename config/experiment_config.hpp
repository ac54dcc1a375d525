// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/controller_config.hpp"
#include "config/named_files.hpp"
#include "config/position.hpp"
#include "config/rig_config.hpp"
#include "ident/acceptance_limits.hpp"
#include "ident/control/trial.hpp"
#include "ident/excitation/excitation.hpp"
#include "ident/fit_options.hpp"
#include "ident/structure/structure_options.hpp"

namespace eha::config {

/// Keeps an integrating rod near where it is predicted to be: `[hold]`.
struct Hold {
  std::optional<double> gain_V_per_in = {};  ///< volts for each inch off the prediction; none: hold_gains().usual
};

/// Ends the run early: `[precision]`.
struct Precision {
  /// Of the gain K of integrator_lag behind the valve's map, fitted to the rows so far: half of its 95 % interval, of
  /// its value [%].
  double gain_percent = 0.0;
};

/// Plays a controller's trial: `[track]`.
struct Track {
  ControllerConfig controller;
  ident::TrialPlan plan;
};

/// A whole experiment.toml.
struct ExperimentConfig {
  std::string name;
  ident::Excitation excitation;         ///< none is played unless is_fitted()
  std::optional<double> place_in = {};  ///< [place]: moves the rod there, in duration_s at most, and plays nothing [in]
  bool brings_back = false;             ///< [place]: also from beyond a travel limit, inward only
  bool characterises = false;           ///< [characterise]: plays what the valve sheet needs, for kSheetDuration_s
  std::optional<Track> track = {};      ///< [track]: plays the trial of a controller, in closed loop
  std::optional<double> start_in = {};  ///< [start]: where the rod is moved first [in]
  std::optional<Hold> hold = {};        ///< [hold]
  std::optional<Precision> precision = {};  ///< [precision]: ends the run after the repetition that reaches it
  double duration_s = 0.0;                  ///< of one repetition [s]
  int repetitions = 1;
  ident::FitOptions fit;  ///< decimation, discarded time, split, procedure, seed
  /// procedure = "both": the paper's procedure too, for comparison.
  bool compares_with_paper = false;
  std::vector<ident::StructureOptions> models;
  ident::AcceptanceLimits acceptance;
  std::string file_name;  ///< as given, for messages
  std::string text;       ///< the file's content as read, for the run's manifest
  PositionMap positions;  ///< position of each key in the file

  /// Whether models are fitted to its record; otherwise it places the rod, measures the valve or tries a controller.
  [[nodiscard]] bool is_fitted() const noexcept { return !place_in && !characterises && !track; }
};

/// Reads an experiment file and the files that it names, and reports everything that is wrong at once, in file order.
/// Checks that need the tick or the rig are in prepare(), see prepared_experiment.hpp.
/// @throws ConfigError      missing, unreadable, not TOML, or wrong
/// @throws PermissionError  the caller may not read it
[[nodiscard]] ExperimentConfig load_experiment(const std::string& path);

/// The same for text already in memory; file_name is used in messages, and with NamedFiles::read as the place from
/// which the experiment's own files are found.
/// @throws ConfigError as load_experiment
[[nodiscard]] ExperimentConfig parse_experiment(std::string_view text, const std::string& file_name,
                                                NamedFiles named_files = NamedFiles::refuse);

/// Ticks of one repetition. Valid after prepare().
[[nodiscard]] std::size_t samples_per_repetition(const ExperimentConfig& experiment, const RigConfig& rig);

}  // namespace eha::config
