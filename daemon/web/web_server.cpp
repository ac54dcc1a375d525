// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/web_server.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <cerrno>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.hpp"

namespace eha::web {
namespace {

constexpr int kBacklog = 128;
constexpr int kSendBuffer = 128 * 1024;
constexpr std::size_t kMostBody = 1024;

/// Set in the thread that accepts while it refuses a connection too many.
thread_local bool refuses = false;
/// The connection of this thread.
thread_local const ClientStream* current = nullptr;
/// What this thread's connection sent was no request, so where the next one begins is unknown.
thread_local bool is_garbled = false;

std::vector<std::string> headers_of(const httplib::Request& request, const char* name) {
  std::vector<std::string> values;
  const auto [begin, end] = request.headers.equal_range(name);
  for (auto item = begin; item != end; ++item) values.push_back(item->second);
  return values;
}

RequestHead head_of(const httplib::Request& request) {
  return {.method = request.method,
          .target = request.target,
          .host = headers_of(request, "Host"),
          .origin = headers_of(request, "Origin"),
          .fetch_site = headers_of(request, "Sec-Fetch-Site"),
          .fetch_mode = headers_of(request, "Sec-Fetch-Mode")};
}

}  // namespace

void refuse(httplib::Response& response, int status, const std::string& message) {
  response.status = status;
  const nlohmann::ordered_json body{{"error", message}};
  response.set_content(body.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace), "application/json");
}

/// Threads of which one serves one connection. A connection too many is handled at once, without a thread.
class WebServer::Threads : public httplib::ThreadPool {
 public:
  explicit Threads(std::atomic<std::size_t>& connections)
      : httplib::ThreadPool(kMostConnections), connections_(connections) {}

  void enqueue(std::function<void()> serve) override {
    if (connections_ >= kMostConnections) {
      refuses = true;
      serve();
      refuses = false;
      return;
    }
    ++connections_;
    httplib::ThreadPool::enqueue(std::move(serve));
  }

 private:
  std::atomic<std::size_t>& connections_;
};

WebServer::WebServer(std::uint16_t port, const StreamLimits& limits, Answerer answer)
    : limits_(limits), answer_(std::move(answer)) {
  new_task_queue = [this] { return new Threads(connections_); };
  set_tcp_nodelay(true);
  // Not SO_REUSEPORT, the library's choice, with which another process could listen at the same port.
  set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    // Of each connection; the kernel would take megabytes for a client that does not read.
    setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof kSendBuffer);
  });
  set_keep_alive_max_count(kMostRequests);
  set_keep_alive_timeout(std::chrono::duration_cast<std::chrono::seconds>(limits_.idle).count());
  set_payload_max_length(kMostBody);
  set_default_headers({{"X-Content-Type-Options", "nosniff"},
                       {"Referrer-Policy", "no-referrer"},
                       {"Cross-Origin-Resource-Policy", "same-origin"},
                       {"X-Frame-Options", "DENY"}});
  set_pre_routing_handler(
      [this](const httplib::Request& request, httplib::Response& response) { return route(request, response); });
  // The body has been read then.
  Post(".*", [this](const httplib::Request& request, httplib::Response& response) { answer_(request, response); });
  set_exception_handler([](const httplib::Request& request, httplib::Response& response, std::exception_ptr thrown) {
    try {
      std::rethrow_exception(std::move(thrown));
    } catch (const std::exception& error) {
      spdlog::error("{}: {}", request.path, error.what());
      refuse(response, 500, error.what());
    } catch (...) {
      refuse(response, 500, "internal error");
    }
  });
  set_error_handler([](const httplib::Request&, httplib::Response& response) {
    if (!response.body.empty()) return;
    is_garbled = true;
    if (current != nullptr && current->is_too_long()) return refuse(response, 431, "the request is too long");
    if (current != nullptr && current->is_too_slow()) return refuse(response, 408, "the request came too slowly");
    refuse(response, response.status, response.status == 404 ? "no such page" : "not a request that this page sends");
  });
  errno = 0;
  const int bound = port == 0 ? bind_to_any_port("127.0.0.1") : (bind_to_port("127.0.0.1", port) ? port : -1);
  if (bound < 0) {
    const int reason = errno;
    const std::string message =
        fmt::format("127.0.0.1:{}: cannot listen there: {}; --port N takes another", port, error_text(reason));
    if (reason == EACCES || reason == EPERM) throw PermissionError(message);
    throw DeviceError(message);
  }
  port_ = static_cast<std::uint16_t>(bound);
  // The library's own backlog is 5.
  if (::listen(svr_sock_, kBacklog) != 0) throw IoError("cannot listen: " + error_text(errno));
}

void WebServer::serve(AccessRules rules) {
  rules_.emplace(std::move(rules));
  if (!listen_after_bind() && !ending_) throw IoError("cannot accept connections: " + error_text(errno));
}

void WebServer::end() {
  ending_ = true;
  if (is_running() && !stopped_.exchange(true)) stop();
}

httplib::Server::HandlerResponse WebServer::route(const httplib::Request& request, httplib::Response& response) {
  response.set_header("Content-Security-Policy", "default-src 'none'; frame-ancestors 'none'");
  response.set_header("Cache-Control", "no-store");
  if (const std::optional<Denial> denial = rules_->check(head_of(request))) {
    refuse(response, denial->status, denial->message);
    return HandlerResponse::Handled;
  }
  if (request.method == "POST") {
    // Without either the library reads until the client closes.
    if (!request.has_header("Content-Length") && !request.has_header("Transfer-Encoding")) {
      refuse(response, 411, "a POST needs Content-Length, also for an empty body");
      return HandlerResponse::Handled;
    }
    // Its body is read first.
    return HandlerResponse::Unhandled;
  }
  answer_(request, response);
  return HandlerResponse::Handled;
}

bool WebServer::process_and_close_socket(socket_t socket) {
  {
    ClientStream stream(socket, limits_);
    if (refuses) {
      stream.send_at_once(
          "HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\nRetry-After: 5\r\nContent-Length: 0\r\n\r\n");
      return false;
    }
    current = &stream;
    serve_connection(stream);
    current = nullptr;
  }
  --connections_;
  return true;
}

void WebServer::serve_connection(ClientStream& stream) {
  bool may_have_body = false;
  const auto set_up = [&](httplib::Request& request) {
    // Compressing what is asked for ten times a second costs more than it saves on the loopback interface; parts of a
    // file may be asked for again and again in one request.
    request.headers.erase("Accept-Encoding");
    request.ranges.clear();
    // A body may be left unread when the request is refused.
    may_have_body =
        request.method != "GET" || request.has_header("Content-Length") || request.has_header("Transfer-Encoding");
    if (may_have_body) {
      request.headers.erase("Connection");
      request.set_header("Connection", "close");
    }
  };
  for (std::size_t i = 1; i <= kMostRequests; ++i) {
    if (!stream.wait_for_request([this] { return !ending_.load(); })) return;
    bool closed = false;
    is_garbled = false;
    if (!process_request(stream, i == kMostRequests, closed, set_up)) return;
    if (closed || is_garbled || stream.is_too_long() || stream.is_too_slow() || may_have_body) return;
  }
}

}  // namespace eha::web
