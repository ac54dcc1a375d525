// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/error.hpp"

namespace eha::cli {

class Console;
struct DesignCommand;

/// `eha design --band LOW:HIGH`: writes an experiment with tones of equal amplitude in a band. Their phases give low
/// peaks of volts, slew and travel; the amplitude is the largest that the rig's three limits allow.
/// @throws ConfigError  the rig has no [following], which predicts the travel   @throws UsageError, IoError
[[nodiscard]] ExitCode design_flat(const DesignCommand& command, Console& console);

}  // namespace eha::cli
