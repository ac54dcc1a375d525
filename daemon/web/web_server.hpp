// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "core/os/file_descriptor.hpp"
#include "daemon/web/access.hpp"
#include "daemon/web/client_stream.hpp"
#include "daemon/web/http.hpp"
#include "daemon/web/listeners.hpp"
#include "daemon/web/seats.hpp"

namespace eha::web {

/// An HTTP server on loopback sockets with limits on connections (one thread each, seats for each user), bytes and
/// time. Every request passes the access rules; every answer has the security headers of the page.
class WebServer : private httplib::Server {
 public:
  /// @param user  at the other end of the connection, looked up when it was accepted
  using Answerer = std::function<void(const httplib::Request&, httplib::Response&, uid_t user)>;

  static constexpr std::size_t kMostRequests = 1'000'000;  ///< of one connection

  /// @param answer  of GET, HEAD and POST; called in many threads; a thrown exception becomes 500
  WebServer(Listeners listeners, const StreamLimits& limits, Answerer answer);

  [[nodiscard]] std::uint16_t port() const noexcept { return listeners_.port(); }

  /// Serves until end() is called, and returns after the last connection is closed. @param rules  for this port
  /// @throws IoError  it cannot wait for connections
  void serve(AccessRules rules);
  /// Ends serve(), even if it has not begun. Thread-safe.
  void end();

  /// Number of connections with a seat.
  [[nodiscard]] std::size_t connections() const;

 private:
  struct Connection;

  HandlerResponse route(const httplib::Request& request, httplib::Response& response);
  void accept_waiting(int listener);
  void admit(os::FileDescriptor socket);
  void serve_connection(ClientStream& stream);

  Listeners listeners_;
  StreamLimits limits_;
  Answerer answer_;
  std::optional<AccessRules> rules_;
  os::FileDescriptor wake_;  ///< becomes readable when serve() must end
  std::atomic<bool> ending_{false};
  Seats seats_;
  mutable std::mutex mutex_;  ///< guards the following members
  std::condition_variable left_;
  std::size_t connections_ = 0;
};

/// Writes {"error": message} and a status into an answer.
void refuse(httplib::Response& response, int status, const std::string& message);

}  // namespace eha::web
