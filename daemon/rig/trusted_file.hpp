// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/rig_config.hpp"

namespace eha {

/// Refuses a comedi rig whose file anyone but root could have written, since its limits protect a machine; the file
/// must still hold what was read.
/// @throws PermissionError  names the file and the command that mends it
/// @throws IoError          it cannot be read any more
void require_trusted_rig_file(const config::RigConfig& rig);

}  // namespace eha
