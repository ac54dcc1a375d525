// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <optional>

namespace eha::web {

/// Stands for an unknown user, if the kernel has neither its socket diagnosis nor its table of connections.
inline constexpr uid_t kUnknownUser = static_cast<uid_t>(-1);

/// Returns the user whose process made a connection over the loopback interface; for a tunnel, the tunnel's user. The
/// kernel knows it only while that process has the connection open: ask when it is accepted. Thread-safe. Cost: one
/// question to the kernel, some 20 us.
/// @param connection  accepted socket of TCP over IPv4 or IPv6
/// @returns none if the other end is already closed
[[nodiscard]] std::optional<uid_t> connection_owner(int connection);

namespace detail {
/// The same from the table /proc/self/net/tcp or tcp6, for a kernel without socket diagnosis. Cost: a line for each
/// connection of the machine.
[[nodiscard]] std::optional<uid_t> connection_owner_in_table(int connection);
}  // namespace detail

}  // namespace eha::web
