// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/web_server.hpp"

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/os/users.hpp"
#include "daemon/web/connection_owner.hpp"

namespace eha::web {
namespace {

constexpr int kSendBuffer = 128 * 1024;
constexpr std::size_t kMostBody = 1024;
constexpr const char* kTooMany =
    "HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\nRetry-After: 5\r\nContent-Length: 0\r\n\r\n";

/// Pause before the next try if no further socket can be opened.
constexpr int kPause_ms = 20;
/// A spare seat requires a prompt request.
constexpr std::chrono::milliseconds kSparePatience{1000};

/// The connection of this thread.
thread_local const ClientStream* current = nullptr;
thread_local uid_t current_user = kUnknownUser;
thread_local Seat current_seat = Seat::none;
/// Whether this thread's connection sent something that is no request, so that the start of the next one is unknown.
thread_local bool is_garbled = false;

std::vector<std::string> headers_of(const httplib::Request& request, const char* name) {
  std::vector<std::string> values;
  const auto [begin, end] = request.headers.equal_range(name);
  for (auto item = begin; item != end; ++item) values.push_back(item->second);
  return values;
}

/// The headers of a request as they were sent. The library decodes "%41" in them, so that another text than a token
/// would equal it, and a token with such a text would not equal itself.
httplib::Headers sent_headers(std::string_view head) {
  constexpr std::string_view kBlank = " \t";
  httplib::Headers headers;
  for (std::size_t end = head.find('\n'); end != std::string_view::npos; end = head.find('\n')) {
    std::string_view line = head.substr(0, end);
    head.remove_prefix(end + 1);
    const std::size_t colon = line.find(':');
    if (!line.ends_with('\r') || colon == 0 || colon == std::string_view::npos) continue;
    std::string_view value = line.substr(colon + 1, line.size() - colon - 2);
    value.remove_prefix(std::min(value.find_first_not_of(kBlank), value.size()));
    value = value.substr(0, value.find_last_not_of(kBlank) + 1);
    headers.emplace(line.substr(0, colon), value);
  }
  return headers;
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

/// The seat of a connection; the destructor gives it back.
struct WebServer::Connection {
  Connection(WebServer& of, uid_t of_user, Seat taken) : server(of), user(of_user), seat(taken) {
    const std::lock_guard lock(server.mutex_);
    ++server.connections_;
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() {
    server.seats_.leave(user, seat);
    const std::lock_guard lock(server.mutex_);
    --server.connections_;
    // Notifies under the lock: the server may be destroyed right after it.
    server.left_.notify_all();
  }

  WebServer& server;
  uid_t user;
  Seat seat;
};

WebServer::WebServer(Listeners listeners, const StreamLimits& limits, Answerer answer)
    : listeners_(std::move(listeners)),
      limits_(limits),
      answer_(std::move(answer)),
      wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!wake_) throw IoError("cannot create an event: " + error_text(errno));
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
  Post(".*", [this](const httplib::Request& request, httplib::Response& response) {
    answer_(request, response, current_user);
  });
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
}

void WebServer::serve(AccessRules rules) {
  rules_.emplace(std::move(rules));
  // The library ends a long answer if svr_sock_ is invalid.
  svr_sock_ = wake_.get();
  std::vector<pollfd> waiting{{.fd = wake_.get(), .events = POLLIN, .revents = 0}};
  for (const os::FileDescriptor& listener : listeners_.sockets()) {
    waiting.push_back({.fd = listener.get(), .events = POLLIN, .revents = 0});
  }
  int reason = 0;
  while (!ending_ && reason == 0) {
    if (poll(waiting.data(), waiting.size(), -1) < 0 && errno != EINTR) reason = errno;
    for (std::size_t i = 1; i < waiting.size() && reason == 0; ++i) {
      if ((waiting[i].revents & POLLIN) != 0) accept_waiting(waiting[i].fd);
      if ((waiting[i].revents & (POLLERR | POLLNVAL)) != 0) reason = EBADF;
    }
  }
  ending_ = true;
  svr_sock_ = INVALID_SOCKET;
  std::unique_lock lock(mutex_);
  left_.wait(lock, [this] { return connections_ == 0; });
  if (reason != 0) throw IoError("cannot wait for connections: " + error_text(reason));
}

void WebServer::end() {
  ending_ = true;
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = write(wake_.get(), &one, sizeof one);
}

std::size_t WebServer::connections() const {
  const std::lock_guard lock(mutex_);
  return connections_;
}

void WebServer::accept_waiting(int listener) {
  // Enough to accept a storm faster than it arrives, and few enough to serve the other address, too.
  constexpr int kAtOnce = 64;
  for (int i = 0; i < kAtOnce && !ending_; ++i) {
    os::FileDescriptor socket(accept4(listener, nullptr, nullptr, SOCK_CLOEXEC));
    if (socket) {
      admit(std::move(socket));
      continue;
    }
    const int reason = errno;
    if (reason == EMFILE || reason == ENFILE || reason == ENOBUFS || reason == ENOMEM) {
      pollfd ending{.fd = wake_.get(), .events = POLLIN, .revents = 0};
      poll(&ending, 1, kPause_ms);
    }
    return;
  }
}

void WebServer::admit(os::FileDescriptor socket) {
  std::optional<uid_t> user = connection_owner(socket.get());
  // The client has gone, and its request could not be attributed to a user.
  if (!user) return;
  user = os::accountable_user(*user);
  const Seat seat = seats_.take(*user);
  if (seat == Seat::none) return ClientStream(socket.release(), limits_).send_at_once(kTooMany);
  const int yes = 1;
  setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  // By default the kernel would buffer megabytes for a client that does not read.
  setsockopt(socket.get(), SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof kSendBuffer);
  StreamLimits limits = limits_;
  if (seat == Seat::spare) {
    limits.idle = std::min(limits.idle, kSparePatience);
    limits.request = std::min(limits.request, kSparePatience);
  }
  auto stream = std::make_unique<ClientStream>(socket.release(), limits);
  auto connection = std::make_unique<Connection>(*this, *user, seat);
  try {
    std::thread([this, held = std::move(connection), client = std::move(stream)]() mutable {
      current = client.get();
      current_user = held->user;
      current_seat = held->seat;
      serve_connection(*client);
      client.reset();
    }).detach();
  } catch (const std::system_error&) {
    // No further thread can be started: closes the connection, as one too many.
  }
}

httplib::Server::HandlerResponse WebServer::route(const httplib::Request& request, httplib::Response& response) {
  response.set_header("Content-Security-Policy", "default-src 'none'; frame-ancestors 'none'");
  response.set_header("Cache-Control", "no-store");
  if (const std::optional<Denial> denial = rules_->check(head_of(request))) {
    refuse(response, denial->status, denial->message);
    return HandlerResponse::Handled;
  }
  if (current_seat == Seat::spare && request.method != "POST") {
    refuse(response, 503, "too many connections of this user; only a stop is answered");
    response.set_header("Connection", "close");
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
  answer_(request, response, current_user);
  return HandlerResponse::Handled;
}

void WebServer::serve_connection(ClientStream& stream) {
  bool may_have_body = false;
  const auto set_up = [&](httplib::Request& request) {
    std::string head = stream.take_head();
    head.erase(0, head.find('\n') + 1);  // the line of the request
    request.headers = sent_headers(head);
    // Compressing answers that are requested ten times a second costs more than it saves on the loopback interface;
    // parts of a file could be requested again and again in one request.
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
    if (closed || is_garbled || current_seat == Seat::spare || stream.is_too_long() || stream.is_too_slow() ||
        may_have_body)
      return;
  }
}

}  // namespace eha::web
