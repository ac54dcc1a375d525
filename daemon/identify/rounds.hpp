// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/identify/source.hpp"
#include "ident/fit_options.hpp"

namespace eha::identify {

/// One round of an identification. While no model is accepted the next one follows: other starts of the search, the
/// ladder of structures, an experiment that says more. Mhd Yusof et al., Int. J. Smart Sensing and Intelligent Systems
/// 9(1), 2016, figure 4.
struct Round {
  /// Of the record, or an experiment to be played: nothing is fitted in that one.
  enum class Kind { fit, experiment };
  std::string what;    ///< "the asked models", "other starts (seed 2)", "an experiment designed for n2 of fo"
  std::string reason;  ///< why it took place, one sentence; empty for the first one
  bool accepted = false;
  Kind kind = Kind::fit;
};

/// An experiment that may determine what the record does not. It is written, never played automatically.
struct NextExperiment {
  std::string text;    ///< TOML
  std::string reason;  ///< one sentence
};

/// File of the next experiment, beside the models or in the run's folder.
inline constexpr std::string_view kNextExperimentFile = "next_experiment.toml";

/// The source's experiment with twice the repetitions: more periods of the same excitation reduce the variance that
/// noise causes. Nothing without an experiment, and nothing beyond 16 repetitions or where the file does not read back.
[[nodiscard]] std::optional<NextExperiment> longer_experiment(const Source& source);

}  // namespace eha::identify
