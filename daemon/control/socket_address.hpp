// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <cstring>
#include <filesystem>

#include "core/error.hpp"

namespace eha::control {

/// @throws ConfigError  the path is longer than the kernel takes (107 bytes)
[[nodiscard]] inline sockaddr_un socket_address(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.native().size() >= sizeof address.sun_path) {
    throw ConfigError(path.string() + ": the path of a socket has at most 107 bytes; choose a shorter one");
  }
  std::memcpy(address.sun_path, path.c_str(), path.native().size() + 1);
  return address;
}

}  // namespace eha::control
