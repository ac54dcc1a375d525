// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "daemon/ehad/options.hpp"

namespace eha::service {

/// Makes the folders of the state and of the socket where they are missing, before anything is written there.
/// @throws PermissionError  they cannot be made, with what else can be done; or this is root and a folder belongs to
///                          another user, whose service files of root would block
void prepare_folders(const Options& options);

}  // namespace eha::service
