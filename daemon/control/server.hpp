// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/os/file_descriptor.hpp"
#include "daemon/control/event_loop.hpp"
#include "daemon/control/line_buffer.hpp"
#include "daemon/control/output_queue.hpp"
#include "daemon/control/protocol.hpp"

namespace eha::control {

using ClientId = std::uint64_t;

/// The process at the other end when it connected, as the kernel reports it (SO_PEERCRED).
struct Peer {
  ClientId client = 0;
  uid_t uid = 0;  ///< of the user who answers for it, see os::accountable_user()
  pid_t pid = 0;
  std::string user;  ///< name of the uid, or its digits
};

/// Limits of clients.
struct ServerLimits {
  std::size_t clients = 256;         ///< connections; beyond this the idlest one of the user with the most is closed
  std::size_t clients_of_user = 64;  ///< connections of one user; requests of further ones are refused
  std::size_t spare_of_user = 8;     ///< further connections of one user, on which `stop` is not refused
  std::size_t unread_bytes = 1024 * 1024;     ///< output waiting for a reader, beyond one answer [bytes]
  std::chrono::milliseconds silence{30'000};  ///< before the first request, within a line, or without reading
};

/// Whether a line of a stream may be dropped.
enum class Delivery {
  when_read,  ///< dropped while earlier output waits to be read
  always,
};

/// The listening side of the socket. All operations are non-blocking and bounded: a client that floods, stalls, sends
/// garbage or reads nothing is answered or dropped, and delays no other client. Connections of one user never close
/// those of another. Each client's requests are answered one at a time, in order; the next one is read after the answer
/// to the last one was read. Not thread-safe.
class Server {
 public:
  using OnRequest = std::function<void(const Peer&, const Request&)>;
  using OnGone = std::function<void(ClientId)>;
  using NameOf = std::function<std::string(uid_t)>;
  using TimePoint = std::chrono::steady_clock::time_point;

  /// Listens at `socket`, mode 0660; replaces the socket of a dead process.
  /// @param on_request  must lead to exactly one respond() or refuse(), now or later
  /// @param on_gone     called when a client that had sent a request has disconnected
  /// @param name_of     name of a user for messages; must not block
  /// @throws DeviceError  another process listens there   @throws IoError, PermissionError, ConfigError (path too long)
  Server(EventLoop& loop, std::filesystem::path socket, ServerLimits limits, OnRequest on_request, OnGone on_gone,
         NameOf name_of);
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  ~Server();

  /// Answers the present request; does nothing if the client has disconnected.
  void respond(ClientId client, std::int64_t id, const Json& result);
  /// The same with the text of the result, which is JSON of one line and may be shared with other answers.
  void respond(ClientId client, std::int64_t id, OutputQueue::Part result);
  void refuse(ClientId client, const Json& id, ExitCode code, std::string_view message);

  /// Sends a line of a stream. @returns false if it was dropped, or the client has disconnected
  bool stream(ClientId client, const std::string& line, Delivery delivery);

  /// Drops clients that were silent for too long. Call about every second.
  void sweep(TimePoint now);

  [[nodiscard]] std::size_t clients() const noexcept { return clients_.size(); }

 private:
  /// A client beyond ServerLimits::clients_of_user may send one stop and nothing else.
  enum class Seat { regular, spare };

  struct Client {
    Peer peer;
    os::FileDescriptor descriptor;
    LineBuffer input{kLongestRequest};
    OutputQueue output;
    bool busy = false;       ///< a request is being answered
    bool closing = false;    ///< dropped once its output is read
    bool has_asked = false;  ///< sent at least one request
    Seat seat = Seat::regular;
    bool at_end = false;   ///< sends no more requests
    TimePoint last_heard;  ///< time of the last whole line
    TimePoint line_begun;  ///< time of the first byte of the unfinished line
    TimePoint last_taken;  ///< time at which output was last read, or was empty
  };

  void accept_clients();
  void make_room();
  [[nodiscard]] std::optional<Seat> seat_for(uid_t uid);
  [[nodiscard]] bool make_seat(uid_t uid, Seat seat, std::size_t most);
  void serve(ClientId id, std::uint32_t events);
  void read_from(Client& client);
  void handle_lines(ClientId id);
  void send(Client& client, std::initializer_list<OutputQueue::Part> parts);
  void send(Client& client, std::string text);
  void flush(Client& client);
  void update_events(Client& client);
  void answer(ClientId id, std::initializer_list<OutputQueue::Part> line);
  void drop(ClientId id);
  [[nodiscard]] Client* find(ClientId id);

  EventLoop& loop_;
  std::filesystem::path path_;
  ServerLimits limits_;
  OnRequest on_request_;
  OnGone on_gone_;
  NameOf name_of_;
  os::FileDescriptor listener_;
  ClientId next_client_ = 1;
  std::map<ClientId, std::unique_ptr<Client>> clients_;
};

}  // namespace eha::control
