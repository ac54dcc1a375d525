// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "config/rig_config.hpp"
#include "core/error.hpp"
#include "daemon/control/socket_path.hpp"
#include "daemon/suggest/commands.hpp"
#include "ident/model/model.hpp"

namespace eha::cli {

class Console;

struct DesignCommand {
  std::optional<std::string> experiment_file = {};           ///< none if only `model_file` is given
  std::optional<std::string> rig_file = {};                  ///< none: the service's, else the default one
  std::filesystem::path socket = control::default_socket();  ///< of the service whose rig is meant without --rig
  std::optional<suggest::RigAccess> of_service = {};         ///< to the service's rig, whose file nobody named
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

/// How the rig of a design is reached.
[[nodiscard]] suggest::RigAccess access_of_design(const DesignCommand& command, const config::RigConfig& rig);

/// "for the limits of /etc/ehad/rig.toml"; of a rig that was not named whose it is, and how to name another one.
[[nodiscard]] std::string limits_of_design(const DesignCommand& command, const config::RigConfig& rig);

/// "written: band.toml, for the limits of /etc/ehad/rig.toml".
[[nodiscard]] std::string written_for(const std::filesystem::path& file, const DesignCommand& command,
                                      const config::RigConfig& rig);

}  // namespace eha::cli
