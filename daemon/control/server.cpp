// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/control/server.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <tuple>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/os/users.hpp"
#include "core/text.hpp"
#include "daemon/control/socket_address.hpp"

namespace eha::control {
namespace {

constexpr std::size_t kReadAtOnce = 64 * 1024;  // [bytes]
constexpr int kLinesAtOnce = 4;                 // of one client
constexpr int kBacklog = 256;
constexpr int kAcceptedAtOnce = 16;

[[noreturn]] void fail(const std::filesystem::path& path, const char* doing, int error_number) {
  const std::string message = fmt::format("{}: cannot {}: {}", path.string(), doing, error_text(error_number));
  if (error_number == EACCES || error_number == EPERM) throw PermissionError(message);
  throw IoError(message);
}

/// Whether a process listens at a socket.
bool is_listened_at(const sockaddr_un& address) {
  const os::FileDescriptor probe(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const int connected = connect(probe.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
  return connected == 0 || errno == EAGAIN;
}

/// Whether bytes wait to be read.
bool has_input(const os::FileDescriptor& descriptor) {
  int bytes = 0;
  return ioctl(descriptor.get(), FIONREAD, &bytes) == 0 && bytes > 0;
}

os::FileDescriptor listen_at(const std::filesystem::path& path) {
  const sockaddr_un address = socket_address(path);
  if (is_listened_at(address)) {
    throw DeviceError(path.string() + ": another ehad already listens there; stop it first");
  }
  if (std::filesystem::is_socket(path)) unlink(path.c_str());
  os::FileDescriptor listener(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!listener) fail(path, "create the socket", errno);
  // The socket must never be open to others, not even before a chmod.
  const mode_t before = umask(0117);
  const int bound = bind(listener.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
  const int reason = errno;
  umask(before);
  if (bound != 0) fail(path, "listen there", reason);
  if (listen(listener.get(), kBacklog) != 0) fail(path, "listen there", errno);
  return listener;
}

}  // namespace

Server::Server(EventLoop& loop, std::filesystem::path socket, ServerLimits limits, OnRequest on_request, OnGone on_gone,
               NameOf name_of)
    : loop_(loop),
      path_(std::move(socket)),
      limits_(limits),
      on_request_(std::move(on_request)),
      on_gone_(std::move(on_gone)),
      name_of_(std::move(name_of)),
      listener_(listen_at(path_)) {
  loop_.add(listener_.get(), EPOLLIN, [this](std::uint32_t) { accept_clients(); });
}

Server::~Server() {
  loop_.remove(listener_.get());
  listener_.close();
  for (const auto& [id, client] : clients_) {
    // Sends waiting output, such as the end of a run.
    flush(*client);
    loop_.remove(client->descriptor.get());
  }
  unlink(path_.c_str());
}

void Server::accept_clients() {
  // A storm of connections must not keep the loop from the requests of those that are connected.
  for (int accepted = 0; accepted < kAcceptedAtOnce; ++accepted) {
    os::FileDescriptor descriptor(accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!descriptor && (errno == EINTR || errno == ECONNABORTED)) continue;
    if (!descriptor) {
      // Without descriptors or memory, connections in the backlog would wake the loop again and again.
      if (errno != EAGAIN) make_room();
      return;
    }
    ucred credentials{};
    socklen_t size = sizeof credentials;
    if (getsockopt(descriptor.get(), SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) continue;
    const uid_t user = os::accountable_user(credentials.uid);
    const std::optional<Seat> seat = seat_for(user);
    if (!seat) continue;
    if (clients_.size() >= limits_.clients) make_room();
    const ClientId id = next_client_++;
    auto client = std::make_unique<Client>();
    client->peer = {id, user, credentials.pid, name_of_(user)};
    client->seat = *seat;
    const int number = descriptor.get();
    client->descriptor = std::move(descriptor);
    client->last_heard = client->last_taken = std::chrono::steady_clock::now();
    loop_.add(number, EPOLLIN, [this, id](std::uint32_t events) { serve(id, events); });
    Client& kept = *clients_.emplace(id, std::move(client)).first->second;
    send(kept, greeting_line());
  }
}

std::optional<Server::Seat> Server::seat_for(uid_t uid) {
  if (make_seat(uid, Seat::regular, limits_.clients_of_user)) return Seat::regular;
  if (make_seat(uid, Seat::spare, limits_.spare_of_user)) return Seat::spare;
  return std::nullopt;
}

bool Server::make_seat(uid_t uid, Seat seat, std::size_t most) {
  std::size_t taken = 0;
  const Client* silent = nullptr;
  for (const auto& [id, client] : clients_) {
    if (client->peer.uid != uid || client->seat != seat) continue;
    ++taken;
    // The oldest one without a request.
    if (silent == nullptr && !client->has_asked && !has_input(client->descriptor)) silent = client.get();
  }
  if (taken < most) return true;
  if (silent == nullptr) return false;
  drop(silent->peer.client);
  return true;
}

void Server::make_room() {
  std::map<uid_t, std::size_t> of_user;
  for (const auto& [id, client] : clients_) ++of_user[client->peer.uid];
  // Among clients of the user with the most connections: first those without a request, then the one silent longest;
  // busy ones last.
  const auto rank = [&](const Client& client) {
    return std::make_tuple(-static_cast<std::ptrdiff_t>(of_user[client.peer.uid]), client.busy, client.has_asked,
                           client.last_heard);
  };
  const auto idlest = std::min_element(clients_.begin(), clients_.end(),
                                       [&](const auto& a, const auto& b) { return rank(*a.second) < rank(*b.second); });
  if (idlest != clients_.end()) drop(idlest->first);
}

Server::Client* Server::find(ClientId id) {
  const auto found = clients_.find(id);
  return found == clients_.end() ? nullptr : found->second.get();
}

void Server::serve(ClientId id, std::uint32_t events) {
  Client* client = find(id);
  if (client == nullptr) return;
  if ((events & EPOLLOUT) != 0) flush(*client);
  if ((events & EPOLLIN) != 0) {
    read_from(*client);
  } else if ((events & (EPOLLHUP | EPOLLERR)) != 0) {
    client->at_end = true;
    client->closing = true;
    client->output.clear();
  }
  handle_lines(id);
  client = find(id);
  if (client == nullptr) return;
  const bool is_over = client->at_end && !client->busy && client->output.empty() && !client->input.has_line();
  if (is_over || (client->closing && client->output.empty())) {
    drop(id);
  } else {
    update_events(*client);
  }
}

void Server::read_from(Client& client) {
  std::array<char, kReadAtOnce> bytes;
  const ssize_t count = recv(client.descriptor.get(), bytes.data(), bytes.size(), 0);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (count <= 0) {
    client.at_end = true;
    return;
  }
  if (client.closing) return;
  if (client.input.size() == 0) client.line_begun = std::chrono::steady_clock::now();
  client.input.append({bytes.data(), static_cast<std::size_t>(count)});
}

void Server::handle_lines(ClientId id) {
  // Looks the client up in each pass, because a request may drop its own client.
  // Handles no request while an answer waits to be read, which bounds the memory of a client that does not read, and
  // few in one pass: the stop of another client waits for the passes before it. update_events() asks for the next one.
  const auto may_ask = [](const Client& client) { return !client.busy && !client.closing && client.output.empty(); };
  std::size_t handled = 0;
  Client* client = find(id);
  for (int lines = 0; client != nullptr && may_ask(*client); client = find(id)) {
    if (++lines > kLinesAtOnce || handled > kReadAtOnce) return;
    const std::optional<std::string> line = client->input.next_line();
    handled += line ? line->size() : 0;
    if (!line) {
      if (client->input.is_too_long()) {
        send(*client,
             error_line(nullptr, ExitCode::usage,
                        fmt::format("a request has at most {} bytes; the connection is closed", kLongestRequest)));
        client->closing = true;
      }
      return;
    }
    const auto now = std::chrono::steady_clock::now();
    client->last_heard = now;
    client->line_begun = now;
    if (line->empty()) continue;
    const std::variant<Request, Refusal> parsed = parse_request(*line);
    if (const auto* refusal = std::get_if<Refusal>(&parsed)) {
      send(*client, error_line(refusal->id, ExitCode::usage, refusal->message));
      continue;
    }
    if (const auto& asked = std::get<Request>(parsed);
        client->seat == Seat::spare && !std::holds_alternative<StopCall>(asked.call)) {
      send(*client, error_line(asked.id, ExitCode::device_unavailable,
                               fmt::format("{} has {} connections to ehad, the most that one user may have: end some "
                                           "of the commands, watches or pages; eha stop still works",
                                           client->peer.user, limits_.clients_of_user)));
      client->closing = true;
      return;
    }
    client->busy = true;
    client->has_asked = true;
    on_request_(client->peer, std::get<Request>(parsed));
  }
}

void Server::send(Client& client, std::string text) {
  send(client, {std::make_shared<const std::string>(std::move(text))});
}

void Server::send(Client& client, std::initializer_list<OutputQueue::Part> parts) {
  const bool all_was_read = client.output.empty();
  if (all_was_read) client.last_taken = std::chrono::steady_clock::now();
  for (const OutputQueue::Part& part : parts) client.output.add(part);
  flush(client);
  if (!all_was_read && client.output.size() > limits_.unread_bytes) {
    // Disconnects a client whose unread output exceeds the limit; skipping lines would corrupt the stream.
    client.output.clear();
    client.closing = true;
  }
  update_events(client);
}

void Server::flush(Client& client) {
  while (!client.output.empty()) {
    const std::string_view next = client.output.front();
    const ssize_t count = ::send(client.descriptor.get(), next.data(), next.size(), MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) break;
    if (count < 0) {
      client.closing = true;
      client.at_end = true;
      client.output.clear();
      return;
    }
    client.output.take(static_cast<std::size_t>(count));
    client.last_taken = std::chrono::steady_clock::now();
  }
}

void Server::update_events(Client& client) {
  std::uint32_t events = 0;
  // Further requests stay in the socket until the answer to this one has been read, and those that came with it are
  // handled: epoll reports nothing for a line that is in our buffer.
  const bool may_ask = !client.busy && client.output.empty();
  const bool has_line = may_ask && client.input.has_line();
  if (!client.at_end && may_ask && !has_line) events |= EPOLLIN;
  if (!client.output.empty() || client.closing || has_line) events |= EPOLLOUT;
  loop_.change(client.descriptor.get(), events);
}

void Server::answer(ClientId id, std::initializer_list<OutputQueue::Part> line) {
  Client* client = find(id);
  if (client == nullptr) return;
  client->busy = false;
  if (client->seat == Seat::spare) client->closing = true;
  send(*client, line);
}

void Server::respond(ClientId client, std::int64_t id, const Json& result) {
  answer(client, {std::make_shared<const std::string>(result_line(id, result))});
}

void Server::respond(ClientId client, std::int64_t id, OutputQueue::Part result) {
  const auto [before, after] = around_result(id);
  answer(client,
         {std::make_shared<const std::string>(before), std::move(result), std::make_shared<const std::string>(after)});
}

void Server::refuse(ClientId client, const Json& id, ExitCode code, std::string_view message) {
  answer(client, {std::make_shared<const std::string>(error_line(id, code, message))});
}

bool Server::stream(ClientId id, const std::string& line, Delivery delivery) {
  Client* client = find(id);
  if (client == nullptr || client->closing) return false;
  if (!client->output.empty() && delivery == Delivery::when_read) return false;
  send(*client, line);
  return true;
}

void Server::sweep(TimePoint now) {
  std::vector<ClientId> silent;
  for (const auto& [id, client] : clients_) {
    const bool has_not_asked = !client->has_asked && now - client->last_heard > limits_.silence;
    const bool has_half_a_line =
        !client->busy && client->input.size() > 0 && now - client->line_begun > limits_.silence;
    const bool does_not_read = !client->output.empty() && now - client->last_taken > limits_.silence;
    // Its socket is full, so epoll reports nothing for it.
    const bool is_done_with = client->closing && client->output.empty();
    if (has_not_asked || has_half_a_line || does_not_read || is_done_with) silent.push_back(id);
  }
  for (const ClientId id : silent) drop(id);
}

void Server::drop(ClientId id) {
  const auto found = clients_.find(id);
  if (found == clients_.end()) return;
  const bool had_asked = found->second->has_asked;
  loop_.remove(found->second->descriptor.get());
  clients_.erase(found);
  if (had_asked) on_gone_(id);
}

}  // namespace eha::control
