// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>

namespace eha::web {

/// The user whose process made a TCP connection over 127.0.0.1, from the kernel's table; one that comes through a
/// tunnel is of the tunnel's user. Reads /proc/self/net/tcp: some 150 bytes for each connection of the machine.
/// Thread-safe.
/// @param client_port  of that process @param server_port  of this one
/// @returns none when the table cannot be read or has no such connection
[[nodiscard]] std::optional<uid_t> connection_owner(std::uint16_t client_port, std::uint16_t server_port);

}  // namespace eha::web
