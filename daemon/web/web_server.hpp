// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "daemon/web/access.hpp"
#include "daemon/web/client_stream.hpp"
#include "daemon/web/http.hpp"

namespace eha::web {

/// An HTTP server on 127.0.0.1 with limits on connections (one thread each), bytes and time. Every request passes the
/// access rules; every answer has the security headers of the page.
class WebServer : private httplib::Server {
 public:
  using Answerer = std::function<void(const httplib::Request&, httplib::Response&)>;

  static constexpr std::size_t kMostConnections = 256;     ///< one more is answered 503 and closed
  static constexpr std::size_t kMostRequests = 1'000'000;  ///< of one connection

  /// Binds the port. @param port  0: any free one   @param answer  of GET, HEAD and POST; called in many threads; a
  /// thrown exception becomes 500
  /// @throws DeviceError  the port is taken   @throws PermissionError, IoError
  WebServer(std::uint16_t port, const StreamLimits& limits, Answerer answer);

  [[nodiscard]] std::uint16_t port() const noexcept { return port_; }

  /// Serves until end() is called. @param rules  for this port
  void serve(AccessRules rules);
  /// Ends serve() once it serves; call until it has returned. Thread-safe.
  void end();

  [[nodiscard]] std::size_t connections() const noexcept { return connections_; }

 private:
  class Threads;

  HandlerResponse route(const httplib::Request& request, httplib::Response& response);
  bool process_and_close_socket(socket_t socket) override;
  void serve_connection(ClientStream& stream);

  StreamLimits limits_;
  Answerer answer_;
  std::optional<AccessRules> rules_;
  std::uint16_t port_ = 0;
  std::atomic<bool> ending_{false};
  std::atomic<bool> stopped_{false};
  std::atomic<std::size_t> connections_{0};
};

/// Puts {"error": message} and a status into an answer.
void refuse(httplib::Response& response, int status, const std::string& message);

}  // namespace eha::web
