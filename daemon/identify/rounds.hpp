// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/identify/source.hpp"
#include "ident/fit_options.hpp"

namespace eha::identify {

/// One round of an identification. While no model is accepted another one follows: other starts of the search, the
/// ladder of structures, a more informative experiment. Mhd Yusof et al., Int. J. Smart Sensing and Intelligent Systems
/// 9(1), 2016, figure 4.
struct Round {
  /// A fit of the record, or an experiment still to be played, in which nothing is fitted.
  enum class Kind { fit, experiment };
  std::string what;    ///< "the asked models", "other starts (seed 2)", "an experiment designed for n2 of fo"
  std::string reason;  ///< reason for this round, one sentence; empty for the first one
  bool accepted = false;
  Kind kind = Kind::fit;
};

/// An experiment that may determine parameters that the record does not. It is written, never played automatically.
struct NextExperiment {
  std::string text;    ///< TOML
  std::string reason;  ///< one sentence
  std::string what = "a longer experiment";
};

/// "the volts went 0.22 V from the valve's null, of which its dead band takes 0.2 V", of a run whose input hardly
/// leaves the dead band of its rig; empty for another one, and for a file.
[[nodiscard]] std::string within_dead_band(const Source& source);

/// "the volts reach 4.85 V of the rig's 5 V", of a run with less than a tenth of the command range left, or that its
/// rod comes to a travel limit, as where that ended it; empty for another one, and for a file.
[[nodiscard]] std::string at_command_limit(const Source& source);

/// File of the next experiment, beside the models or in the run's folder.
inline constexpr std::string_view kNextExperimentFile = "next_experiment.toml";

/// Returns the source's experiment with twice the repetitions, and at least two whole ones behind the discarded time:
/// more periods of the same excitation reduce the variance due to noise. In place of an input that hardly moves, as a
/// step, or hardly leaves the valve's dead band, and of what the rehearsal on the rig of the run does not let pass, a
/// multisine of three tones that it does. Nothing without an experiment, beyond 16 repetitions, if the file cannot be
/// read back, or if the rehearsal lets neither pass. A rig that cannot be rehearsed, or none, refuses nothing.
/// @param used_s  length that is asked for behind the discarded time, for which there may be 200 repetitions; 0: none
[[nodiscard]] std::optional<NextExperiment> longer_experiment(const Source& source, double used_s = 0.0);

}  // namespace eha::identify
