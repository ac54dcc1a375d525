// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/connection_owner.hpp"

#include <fmt/format.h>
#include <linux/inet_diag.h>
#include <linux/netlink.h>
#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>

#include "core/os/file_descriptor.hpp"

namespace eha::web {
namespace {

/// One end of a connection.
struct End {
  sa_family_t family = AF_UNSPEC;
  std::array<std::uint32_t, 4> address{};  ///< network byte order; IPv4 in the first
  std::uint16_t port = 0;                  ///< network byte order
};

End end_of(int connection, int (*name_of)(int, sockaddr*, socklen_t*)) {
  sockaddr_storage storage{};
  socklen_t size = sizeof storage;
  End end;
  if (name_of(connection, reinterpret_cast<sockaddr*>(&storage), &size) != 0) return end;
  end.family = storage.ss_family;
  if (storage.ss_family == AF_INET) {
    const auto& address = reinterpret_cast<const sockaddr_in&>(storage);
    end.address[0] = address.sin_addr.s_addr;
    end.port = address.sin_port;
  } else if (storage.ss_family == AF_INET6) {
    const auto& address = reinterpret_cast<const sockaddr_in6&>(storage);
    std::memcpy(end.address.data(), &address.sin6_addr, sizeof address.sin6_addr);
    end.port = address.sin6_port;
  }
  return end;
}

/// Whether the other end reset the connection.
bool is_reset(int connection) {
  char byte = 0;
  return recv(connection, &byte, 1, MSG_PEEK | MSG_DONTWAIT) < 0 && errno != EAGAIN && errno != EINTR;
}

enum class Found { socket, nothing, no_diagnosis };

struct Diagnosis {
  Found found = Found::no_diagnosis;
  uid_t user = 0;
  std::uint32_t inode = 0;  ///< 0: no process has the socket open any longer
};

/// Asks sock_diag(7) for the socket whose own end is `own` and whose other end is `other`.
Diagnosis diagnose(const End& own, const End& other) {
  struct {
    nlmsghdr head;
    inet_diag_req_v2 question;
  } request{};
  // The socket is kept, so that a storm of connections is answered as fast as their owners are found.
  thread_local os::FileDescriptor netlink;
  thread_local std::uint32_t asked = 0;
  request.head.nlmsg_len = sizeof request;
  request.head.nlmsg_type = SOCK_DIAG_BY_FAMILY;
  request.head.nlmsg_flags = NLM_F_REQUEST;
  request.head.nlmsg_seq = ++asked;
  request.question.sdiag_family = static_cast<std::uint8_t>(own.family);
  request.question.sdiag_protocol = IPPROTO_TCP;
  request.question.idiag_states = ~0U;
  request.question.id.idiag_sport = own.port;
  request.question.id.idiag_dport = other.port;
  std::memcpy(request.question.id.idiag_src, own.address.data(), sizeof own.address);
  std::memcpy(request.question.id.idiag_dst, other.address.data(), sizeof other.address);
  request.question.id.idiag_cookie[0] = request.question.id.idiag_cookie[1] = INET_DIAG_NOCOOKIE;

  if (!netlink) {
    netlink = os::FileDescriptor(socket(AF_NETLINK, SOCK_DGRAM | SOCK_CLOEXEC, NETLINK_SOCK_DIAG));
    // A connected socket accepts only datagrams of the kernel.
    const sockaddr_nl kernel{.nl_family = AF_NETLINK, .nl_pad = 0, .nl_pid = 0, .nl_groups = 0};
    if (netlink && connect(netlink.get(), reinterpret_cast<const sockaddr*>(&kernel), sizeof kernel) != 0) {
      netlink = os::FileDescriptor();
    }
  }
  if (!netlink || send(netlink.get(), &request, sizeof request, 0) != sizeof request) return {};
  alignas(nlmsghdr) std::array<char, 2048> bytes{};
  const auto* answer = reinterpret_cast<const nlmsghdr*>(bytes.data());
  ssize_t count = 0;
  // The kernel answers within send(); skips answers to earlier questions.
  do {
    count = recv(netlink.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (count < static_cast<ssize_t>(sizeof(nlmsghdr))) return {};
  } while (answer->nlmsg_seq != asked);
  if (answer->nlmsg_type == NLMSG_ERROR && count >= static_cast<ssize_t>(NLMSG_LENGTH(sizeof(nlmsgerr)))) {
    const auto* error = static_cast<const nlmsgerr*>(NLMSG_DATA(answer));
    return {.found = error->error == -ENOENT ? Found::nothing : Found::no_diagnosis};
  }
  if (answer->nlmsg_type != SOCK_DIAG_BY_FAMILY || count < static_cast<ssize_t>(NLMSG_LENGTH(sizeof(inet_diag_msg)))) {
    return {};
  }
  const auto* socket = static_cast<const inet_diag_msg*>(NLMSG_DATA(answer));
  return {Found::socket, socket->idiag_uid, socket->idiag_inode};
}

/// proc(5): each word of an address is the number in memory (network byte order), the port is the plain number.
std::string in_table(const End& end) {
  std::string text;
  const std::size_t words = end.family == AF_INET ? 1 : end.address.size();
  for (std::size_t i = 0; i < words; ++i) text += fmt::format("{:08X}", end.address[i]);
  return text + fmt::format(":{:04X}", ntohs(end.port));
}

}  // namespace

std::optional<uid_t> detail::connection_owner_in_table(int connection) {
  const End client = end_of(connection, getpeername);
  const std::string own = in_table(client);
  const std::string other = in_table(end_of(connection, getsockname));
  std::ifstream table(client.family == AF_INET ? "/proc/self/net/tcp" : "/proc/self/net/tcp6");
  if (!table) return kUnknownUser;
  for (std::string line; std::getline(table, line);) {
    std::istringstream words(line);
    std::string slot, local, remote, state, queues, timer, retransmits, timeout;
    uid_t user = 0;
    std::uint64_t inode = 0;
    if (!(words >> slot >> local >> remote >> state >> queues >> timer >> retransmits >> user >> timeout >> inode)) {
      continue;
    }
    // Without an inode no process has it open, and the kernel shows root as its user.
    if (local == own && remote == other) return inode == 0 ? std::nullopt : std::optional(user);
  }
  return std::nullopt;
}

std::optional<uid_t> connection_owner(int connection) {
  // A kernel without the diagnosis answers as if there were no such socket.
  static std::atomic<bool> has_diagnosis{false};
  if (is_reset(connection)) return std::nullopt;
  const End client = end_of(connection, getpeername);
  if (client.family == AF_UNSPEC) return std::nullopt;
  const Diagnosis found = diagnose(client, end_of(connection, getsockname));
  if (found.found == Found::socket) {
    has_diagnosis = true;
    return found.inode == 0 ? std::nullopt : std::optional(found.user);
  }
  if (found.found == Found::nothing && has_diagnosis) return std::nullopt;
  return detail::connection_owner_in_table(connection);
}

}  // namespace eha::web
