// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "config/rig_config.hpp"

namespace eha {

/// Refuses a rig that moves a machine if anyone but root could have written its file, whose limits protect the machine.
/// The file must still have the content that was read.
/// @throws PermissionError  names the file and the command that corrects it
/// @throws IoError          it can no longer be read
void require_trusted_rig_file(const config::RigConfig& rig);

/// Whether a file lies in /etc/ehad or below, in a folder there that only root changes.
[[nodiscard]] bool is_site_rig_file(const std::string& file_name);

/// The same for a rig that a user opens in the user's own process (--local). For a rig that moves a machine users other
/// than root may use only files of /etc/ehad, because root owns many files with a rig's keys, for example the examples.
/// @throws PermissionError, IoError  as require_trusted_rig_file
void require_local_rig_file(const config::RigConfig& rig);

}  // namespace eha
