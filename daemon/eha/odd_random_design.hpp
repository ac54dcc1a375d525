// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/error.hpp"

namespace eha::cli {

class Console;
struct DesignCommand;

/// `eha design --band LOW:HIGH --odd-random`: writes an experiment with realisations of an odd-random multisine in a
/// band, as large as the first of the rig's limits of volts, slew and travel allows.
/// @throws ConfigError  the rig has no [following], which predicts the travel, or the band holds no odd line
/// @throws IoError
[[nodiscard]] ExitCode design_odd_random(const DesignCommand& command, Console& console);

}  // namespace eha::cli
