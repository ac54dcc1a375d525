// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/rig_config.hpp"

namespace eha {

/// Refuses a comedi rig whose file anyone but root could have written, since its limits protect a machine.
/// @throws PermissionError  names the file and the command that mends it
void require_trusted_rig_file(const config::RigConfig& rig);

}  // namespace eha
