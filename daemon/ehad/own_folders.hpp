// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "daemon/ehad/service_options.hpp"

namespace eha::service {

/// Creates the folders of the state and of the socket if they are missing, before anything is written there.
/// @throws PermissionError  they cannot be created; the message gives alternatives. Or this is root and a folder
///                          belongs to another user, whose service root's files would block
void prepare_folders(const Options& options);

}  // namespace eha::service
