// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/rig_config.hpp"

namespace eha {

/// Refuses a rig that moves a machine if anyone but root could have written its file, whose limits protect the machine;
/// the file must still hold what was read.
/// @throws PermissionError  names the file and the command that mends it
/// @throws IoError          it cannot be read any more
void require_trusted_rig_file(const config::RigConfig& rig);

}  // namespace eha
