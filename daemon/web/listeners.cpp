// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/listeners.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <systemd/sd-daemon.h>

#include <cerrno>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/error.hpp"

namespace eha::web {
namespace {

constexpr int kBacklog = 4096;  // the kernel's own limit; a storm of connections must not crowd out a stop
constexpr int kMostTries = 50;

struct Address {
  sockaddr_storage storage{};
  socklen_t size = 0;
};

Address loopback(int family, std::uint16_t port) {
  Address address;
  if (family == AF_INET) {
    auto& v4 = reinterpret_cast<sockaddr_in&>(address.storage);
    v4.sin_family = AF_INET;
    v4.sin_port = htons(port);
    v4.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.size = sizeof v4;
  } else {
    auto& v6 = reinterpret_cast<sockaddr_in6&>(address.storage);
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(port);
    v6.sin6_addr = in6addr_loopback;
    address.size = sizeof v6;
  }
  return address;
}

/// Returns the port of a socket that is bound to a loopback address; none for another one.
std::optional<std::uint16_t> loopback_port(int socket) {
  sockaddr_storage storage{};
  socklen_t size = sizeof storage;
  if (getsockname(socket, reinterpret_cast<sockaddr*>(&storage), &size) != 0) return std::nullopt;
  if (storage.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(storage);
    if (v4.sin_addr.s_addr == htonl(INADDR_LOOPBACK)) return ntohs(v4.sin_port);
  } else if (storage.ss_family == AF_INET6) {
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(storage);
    if (IN6_IS_ADDR_LOOPBACK(&v6.sin6_addr)) return ntohs(v6.sin6_port);
  }
  return std::nullopt;
}

/// @returns none if the kernel has no such family; errno gives the reason why an empty one could not listen
std::optional<os::FileDescriptor> listen_at(int family, std::uint16_t port) {
  os::FileDescriptor opened(socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!opened && errno == EAFNOSUPPORT) return std::nullopt;
  if (!opened) return opened;
  const int yes = 1;
  // Not SO_REUSEPORT, with which another process could listen at the same port.
  setsockopt(opened.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (family == AF_INET6) {
    setsockopt(opened.get(), IPPROTO_IPV6, IPV6_V6ONLY, &yes, sizeof yes);
    // Binds even if the address is switched off at present.
    setsockopt(opened.get(), IPPROTO_IPV6, IPV6_FREEBIND, &yes, sizeof yes);
  }
  const Address address = loopback(family, port);
  if (bind(opened.get(), reinterpret_cast<const sockaddr*>(&address.storage), address.size) != 0 ||
      listen(opened.get(), kBacklog) != 0) {
    return os::FileDescriptor();
  }
  return opened;
}

[[noreturn]] void refuse(const char* host, std::uint16_t port, int reason) {
  const std::string message =
      fmt::format("{}:{}: cannot listen there: {}; --port N takes another", host, port, error_text(reason));
  if (reason == EACCES || reason == EPERM) throw PermissionError(message);
  throw DeviceError(message);
}

}  // namespace

Listeners Listeners::inherited() {
  Listeners all;
  const int count = sd_listen_fds(1);
  if (count < 0) throw IoError("cannot take the sockets of the service manager: " + error_text(-count));
  for (int i = 0; i < count; ++i) {
    os::FileDescriptor socket(SD_LISTEN_FDS_START + i);
    const std::optional<std::uint16_t> port = loopback_port(socket.get());
    if (!port || sd_is_socket(socket.get(), AF_UNSPEC, SOCK_STREAM, 1) <= 0) {
      throw ConfigError("a socket of the service manager does not listen on 127.0.0.1 or [::1]");
    }
    if (!all.sockets_.empty() && *port != all.port_) {
      throw ConfigError(
          fmt::format("the service manager's sockets have the ports {} and {}; expected one port", all.port_, *port));
    }
    if (fcntl(socket.get(), F_SETFL, fcntl(socket.get(), F_GETFL) | O_NONBLOCK) != 0) {
      throw IoError("cannot set up a socket: " + error_text(errno));
    }
    all.port_ = *port;
    all.sockets_.push_back(std::move(socket));
  }
  return all;
}

Listeners Listeners::on_port(std::uint16_t port) {
  for (int tries = 1;; ++tries) {
    std::optional<os::FileDescriptor> v4 = listen_at(AF_INET, port);
    if (!v4 || !*v4) refuse("127.0.0.1", port, errno);
    Listeners all;
    all.port_ = loopback_port(v4->get()).value_or(port);
    std::optional<os::FileDescriptor> v6 = listen_at(AF_INET6, all.port_);
    const int reason = errno;
    if (v6 && !*v6) {
      // Any free port: another one may be free on both.
      if (port == 0 && reason == EADDRINUSE && tries < kMostTries) continue;
      refuse("[::1]", all.port_, reason);
    }
    all.sockets_.push_back(std::move(*v4));
    if (v6) all.sockets_.push_back(std::move(*v6));
    return all;
  }
}

}  // namespace eha::web
