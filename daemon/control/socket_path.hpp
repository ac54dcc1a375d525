// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

namespace eha::control {

inline constexpr const char* kDefaultSocket = "/run/ehad/ehad.sock";

/// The environment's EHA_SOCKET, otherwise kDefaultSocket.
[[nodiscard]] std::filesystem::path default_socket();

}  // namespace eha::control
