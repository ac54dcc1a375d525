// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

namespace eha::control {

inline constexpr const char* kDefaultSocket = "/run/ehad/ehad.sock";

/// Returns EHA_SOCKET of the environment, otherwise kDefaultSocket.
[[nodiscard]] std::filesystem::path default_socket();

}  // namespace eha::control
