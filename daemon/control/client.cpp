// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/control/client.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <string_view>

#include "core/error.hpp"
#include "daemon/control/socket_address.hpp"

namespace eha::control {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr std::size_t kLongestAnswer = 64 * 1024 * 1024;

/// Limits the time that the kernel waits for room, also for a place in the queue of connecting clients.
void limit_waiting(const os::FileDescriptor& descriptor, milliseconds patience) {
  const milliseconds::rep left_ms = std::max<milliseconds::rep>(patience.count(), 1);
  const timeval limit{.tv_sec = left_ms / 1000, .tv_usec = left_ms % 1000 * 1000};
  setsockopt(descriptor.get(), SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
}

os::FileDescriptor connect_to(const std::filesystem::path& path, milliseconds patience) {
  const sockaddr_un address = socket_address(path);
  os::FileDescriptor descriptor(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (!descriptor) throw DeviceError("cannot create a socket: " + error_text(errno));
  limit_waiting(descriptor, patience);
  if (connect(descriptor.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return descriptor;
  const int error_number = errno;
  if (error_number == EACCES || error_number == EPERM) {
    throw PermissionError(
        fmt::format("{}: {}; only members of the socket's group may use ehad; as root: adduser NAME ehad, then log in "
                    "again",
                    path.string(), error_text(error_number)));
  }
  if (error_number == EAGAIN) throw ConnectionLost(path.string() + ": ehad accepts no connection");
  throw DeviceError(fmt::format(
      "ehad is not running ({}: {}). Its guard, eha-safe, makes the rig safe when ehad ends; look at the rig, and if "
      "it moves, use its emergency stop. Then start ehad ({}), and eha status says what it found",
      path.string(), error_text(error_number),
      path == kDefaultSocket ? "systemctl start ehad" : fmt::format("with --socket {}", path.string())));
}

}  // namespace

std::filesystem::path default_socket() {
  const char* named = std::getenv("EHA_SOCKET");
  return named != nullptr && *named != '\0' ? named : kDefaultSocket;
}

Client::Client(const std::filesystem::path& socket, milliseconds patience) : path_(socket), input_(kLongestAnswer) {
  const auto deadline = steady_clock::now() + patience;
  descriptor_ = connect_to(socket, patience);
  const auto left = std::chrono::duration_cast<milliseconds>(deadline - steady_clock::now());
  const std::optional<Json> greeting = next_line(left);
  if (!greeting) {
    lost(fmt::format("no greeting within {:.3g} s", std::chrono::duration<double>(patience).count()));
  }
  const bool is_ours = greeting->is_object() && greeting->contains("ehad") && greeting->contains("protocol");
  if (!is_ours || !greeting->at("ehad").is_string() || greeting->at("protocol") != kProtocolVersion) {
    throw DeviceError(
        fmt::format("{}: the program there does not speak protocol {} of ehad; install the same version of eha "
                    "and ehad",
                    path_.string(), kProtocolVersion));
  }
  version_ = greeting->at("ehad").get<std::string>();
}

std::optional<pid_t> Client::service_process() const noexcept {
  ucred peer{};
  socklen_t size = sizeof peer;
  const bool is_known = getsockopt(descriptor_.get(), SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 && peer.pid > 0;
  return is_known ? std::optional(peer.pid) : std::nullopt;
}

void Client::lost(const std::string& why) const {
  throw ConnectionLost(fmt::format("{}: the connection to ehad is lost: {}", path_.string(), why));
}

Json Client::call(const std::string& method, const Json& params, milliseconds patience,
                  const std::function<bool()>& gives_up) {
  constexpr milliseconds kLook(200);  // a signal between the question and the wait would not end the wait
  const auto deadline = steady_clock::now() + patience;
  limit_waiting(descriptor_, patience);
  const std::int64_t id = next_id_++;
  const Json request{{"id", id}, {"method", method}, {"params", params}};
  const std::string text = request.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  for (std::string_view rest = text; !rest.empty();) {
    const ssize_t sent = ::send(descriptor_.get(), rest.data(), rest.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) lost(error_text(errno));
    rest.remove_prefix(static_cast<std::size_t>(sent));
  }
  for (;;) {
    const auto left = std::chrono::duration_cast<milliseconds>(deadline - steady_clock::now());
    if (left <= milliseconds::zero()) {
      lost(fmt::format("no answer to {} within {:.3g} s", method, std::chrono::duration<double>(patience).count()));
    }
    const bool is_given_up = gives_up && gives_up();
    const std::optional<Json> answer = next_line(is_given_up ? milliseconds::zero()
                                                 : gives_up  ? std::min(left, kLook)
                                                             : left);
    if (!answer && is_given_up) {
      descriptor_ = {};
      throw CallGivenUp();
    }
    if (!answer || !answer->contains("id") || answer->at("id") != id) continue;
    if (answer->contains("result")) return answer->at("result");
    const Json error = answer->value("error", Json::object());
    throw Error(static_cast<ExitCode>(error.value("code", 1)), error.value("message", "ehad gave no reason"));
  }
}

std::optional<Json> Client::next_event(milliseconds timeout) {
  std::optional<Json> line = next_line(timeout);
  if (!line || !line->contains("snapshot")) return std::nullopt;
  return line->at("snapshot");
}

std::optional<Json> Client::next_line(milliseconds timeout) {
  const auto deadline = steady_clock::now() + timeout;
  for (;;) {
    if (const std::optional<std::string> line = input_.next_line()) {
      Json parsed = Json::parse(*line, nullptr, false);
      if (!parsed.is_object()) lost("it sent something other than a JSON object");
      return parsed;
    }
    if (input_.is_too_long()) lost("it sent a line without an end");
    const auto left = std::chrono::duration_cast<milliseconds>(deadline - steady_clock::now());
    pollfd waiting{.fd = descriptor_.get(), .events = POLLIN, .revents = 0};
    const int ready = poll(&waiting, 1, static_cast<int>(std::max<milliseconds::rep>(0, left.count())));
    if (ready == 0 || (ready < 0 && errno == EINTR)) return std::nullopt;
    std::array<char, 65536> bytes;
    const ssize_t count = recv(descriptor_.get(), bytes.data(), bytes.size(), 0);
    if (count < 0 && errno == EINTR) return std::nullopt;
    if (count < 0) lost(error_text(errno));
    if (count == 0) lost("ehad closed it");
    input_.append({bytes.data(), static_cast<std::size_t>(count)});
  }
}

}  // namespace eha::control
