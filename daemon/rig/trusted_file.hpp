// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "config/rig_config.hpp"

namespace eha {

/// Refuses a rig that moves a machine if anyone but root could have written its file, whose limits protect the machine;
/// the file must still hold what was read.
/// @throws PermissionError  names the file and the command that mends it
/// @throws IoError          it cannot be read any more
void require_trusted_rig_file(const config::RigConfig& rig);

/// Whether a file lies in /etc/ehad or below, in a folder there that only root changes.
[[nodiscard]] bool is_site_rig_file(const std::string& file_name);

/// The same for a rig that a user opens in an own process (--local): of a rig that moves a machine, another user than
/// root takes only files of /etc/ehad, because root owns many files with a rig's keys, examples among them.
/// @throws PermissionError, IoError  as require_trusted_rig_file
void require_local_rig_file(const config::RigConfig& rig);

}  // namespace eha
