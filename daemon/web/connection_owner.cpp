// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/connection_owner.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>

#include <fstream>
#include <sstream>
#include <string>

namespace eha::web {

std::optional<uid_t> connection_owner(std::uint16_t client_port, std::uint16_t server_port) {
  // proc(5): the address is the number in memory (network byte order), the port is the plain number.
  const std::uint32_t loopback = htonl(INADDR_LOOPBACK);
  const std::string client = fmt::format("{:08X}:{:04X}", loopback, client_port);
  const std::string server = fmt::format("{:08X}:{:04X}", loopback, server_port);
  std::ifstream table("/proc/self/net/tcp");
  for (std::string line; std::getline(table, line);) {
    std::istringstream words(line);
    std::string slot, local, remote, state, queues, timer, retransmits;
    uid_t owner = 0;
    if (!(words >> slot >> local >> remote >> state >> queues >> timer >> retransmits >> owner)) continue;
    if (local == client && remote == server) return owner;
  }
  return std::nullopt;
}

}  // namespace eha::web
