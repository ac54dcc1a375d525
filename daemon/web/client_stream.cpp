// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/client_stream.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace eha::web {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kSlice{200};
constexpr milliseconds kLinger{1000};
constexpr std::size_t kMostLingering = 2u << 20;

/// Sets the address and the port at one end of a connection; changes nothing if they are not known.
void read_end(int socket, int (*name_of)(int, sockaddr*, socklen_t*), std::string& ip, int& port) {
  sockaddr_storage storage{};
  socklen_t size = sizeof storage;
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (name_of(socket, reinterpret_cast<sockaddr*>(&storage), &size) != 0) return;
  if (storage.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(storage);
    inet_ntop(AF_INET, &v4.sin_addr, text.data(), text.size());
    port = ntohs(v4.sin_port);
  } else if (storage.ss_family == AF_INET6) {
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(storage);
    inet_ntop(AF_INET6, &v6.sin6_addr, text.data(), text.size());
    port = ntohs(v6.sin6_port);
  }
  ip = text.data();
}

}  // namespace

ClientStream::~ClientStream() {
  shutdown(socket_, SHUT_WR);
  const auto deadline = Clock::now() + kLinger;
  std::array<char, 4096> rest;
  for (std::size_t taken = 0; has_answered_ && taken < kMostLingering && wait(POLLIN, deadline);) {
    const ssize_t count = recv(socket_, rest.data(), rest.size(), MSG_DONTWAIT);
    if (count <= 0) break;
    taken += static_cast<std::size_t>(count);
  }
  close(socket_);
}

bool ClientStream::wait(short events, Clock::time_point deadline) const {
  for (;;) {
    const auto left = std::chrono::ceil<milliseconds>(deadline - Clock::now());
    if (left <= milliseconds::zero()) return false;
    pollfd waiting{.fd = socket_, .events = events, .revents = 0};
    const int ready = poll(&waiting, 1, static_cast<int>(left.count()));
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
}

bool ClientStream::wait_for_request(const std::function<bool()>& goes_on) {
  const auto deadline = Clock::now() + limits_.idle;
  while (begin_ == end_ && !wait(POLLIN, std::min(deadline, Clock::now() + kSlice))) {
    if (Clock::now() >= deadline || !goes_on()) return false;
  }
  if (!goes_on()) return false;
  left_ = limits_.request_bytes;
  too_long_ = too_slow_ = has_answered_ = false;
  written_ = 0;
  head_.clear();
  keeps_head_ = true;
  request_deadline_ = Clock::now() + limits_.request;
  return true;
}

ssize_t ClientStream::read(char* bytes, size_t size) {
  if (left_ == 0) {
    too_long_ = true;
    return -1;
  }
  if (begin_ == end_) {
    if (!wait(POLLIN, request_deadline_)) {
      too_slow_ = true;
      return -1;
    }
    const ssize_t count = recv(socket_, buffer_.data(), buffer_.size(), 0);
    if (count <= 0) return count;
    begin_ = 0;
    end_ = static_cast<std::size_t>(count);
  } else if (Clock::now() > request_deadline_) {
    too_slow_ = true;
    return -1;
  }
  const std::size_t taken = std::min({size, end_ - begin_, left_});
  std::memcpy(bytes, buffer_.data() + begin_, taken);
  begin_ += taken;
  left_ -= taken;
  if (keeps_head_) head_.append(bytes, taken);
  return static_cast<ssize_t>(taken);
}

std::string ClientStream::take_head() {
  keeps_head_ = false;
  return std::exchange(head_, {});
}

ClientStream::Clock::time_point ClientStream::answer_deadline() const {
  if (!has_answered_) return Clock::now() + limits_.answer;
  const milliseconds at_least_rate(1000 * written_ / std::max<std::size_t>(limits_.least_bytes_per_s, 1));
  return std::min(last_taken_, answer_begun_ + at_least_rate) + limits_.answer;
}

ssize_t ClientStream::write(const char* bytes, size_t size) {
  if (!has_answered_) answer_begun_ = last_taken_ = Clock::now();
  has_answered_ = true;
  for (;;) {
    const ssize_t count = send(socket_, bytes, size, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count >= 0) {
      written_ += static_cast<std::size_t>(count);
      last_taken_ = Clock::now();
      return count;
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN || !wait(POLLOUT, answer_deadline())) return -1;
  }
}

void ClientStream::send_at_once(const std::string& text) const {
  // A client without room for a line receives none.
  [[maybe_unused]] const ssize_t sent = send(socket_, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

void ClientStream::get_remote_ip_and_port(std::string& ip, int& port) const {
  read_end(socket_, getpeername, ip, port);
}

void ClientStream::get_local_ip_and_port(std::string& ip, int& port) const { read_end(socket_, getsockname, ip, port); }

}  // namespace eha::web
