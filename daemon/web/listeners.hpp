// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "core/os/file_descriptor.hpp"

namespace eha::web {

/// Listening sockets on 127.0.0.1 and [::1]. Both are needed, because a browser resolves `localhost` to either address:
/// another user listening on one of them could show another page there and ask for the token.
class Listeners {
 public:
  /// Returns the sockets that the service manager keeps through restarts (sd_listen_fds(3)); may be empty.
  /// @throws ConfigError  one of them is no listening TCP socket of the loopback interface, or their ports differ
  [[nodiscard]] static Listeners inherited();

  /// Opens both at one port. @param port  0: any that is free on both
  /// On a kernel without IPv6 opens the first only; nobody can listen on the second then.
  /// @throws DeviceError  the port is taken on one of them   @throws PermissionError, IoError
  [[nodiscard]] static Listeners on_port(std::uint16_t port);

  [[nodiscard]] bool empty() const noexcept { return sockets_.empty(); }
  [[nodiscard]] std::uint16_t port() const noexcept { return port_; }
  [[nodiscard]] const std::vector<os::FileDescriptor>& sockets() const noexcept { return sockets_; }

 private:
  std::vector<os::FileDescriptor> sockets_;  ///< they do not block
  std::uint16_t port_ = 0;
};

}  // namespace eha::web
