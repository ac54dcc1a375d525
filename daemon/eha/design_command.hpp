// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "ident/model/model.hpp"

namespace eha::cli {

class Console;

struct DesignCommand {
  std::optional<std::string> experiment_file = {};  ///< none if only `model_file` is given
  std::optional<std::string> rig_file = {};
  std::optional<std::filesystem::path> output = {};
  std::optional<std::string> model_file = {};  ///< --from: writes the experiment that improves this model
  std::string parameter = {};                  ///< --improve
  std::optional<double> wanted_std = {};       ///< --to
  std::optional<std::string> twin_file = {};   ///< --twin: simulated rig for predictions; none: the rig if simulated
  std::optional<ident::FrequencyInterval> band = {};  ///< --band: writes an experiment of equal tones in this band
  int tones = 30;
  double period_s = 20.0;                        ///< of the tones
  std::optional<int> repetitions = {};           ///< of the period; none: three periods as one
  std::optional<double> precision_percent = {};  ///< --precision: of the gain; none: every repetition is played
  std::optional<int> realisations = {};          ///< --odd-random: of an odd-random multisine in the band; none: tones
};

[[nodiscard]] ExitCode execute(const DesignCommand& command, Console& console);

}  // namespace eha::cli
