// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <poll.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>

#include "daemon/web/http.hpp"

namespace eha::web {

/// Limits on one connection.
struct StreamLimits {
  std::size_t request_bytes = 16 * 1024;      ///< of a request, its body included
  std::chrono::milliseconds idle{5'000};      ///< until the first byte of a request
  std::chrono::milliseconds request{5'000};   ///< from its first byte to its last
  std::chrono::milliseconds answer{10'000};   ///< longest pause in reading an answer; all of it may take this
                                              ///< and the time at least_bytes_per_s
  std::size_t least_bytes_per_s = 16 * 1024;  ///< least speed at which a client must read a long answer
};

/// A connection with limits on the bytes and the time of a request and on the time of an answer. Closes a client that
/// sends or reads too slowly. Owns the socket. Belongs to one thread.
class ClientStream : public httplib::Stream {
 public:
  ClientStream(int socket, const StreamLimits& limits) : socket_(socket), limits_(limits) {}
  ClientStream(const ClientStream&) = delete;
  ClientStream& operator=(const ClientStream&) = delete;
  /// Closes the connection after reading the client's remaining bytes for a moment, because unread bytes would destroy
  /// the answer.
  ~ClientStream() override;

  /// Waits for the first byte of a request, whose limits begin then.
  /// @param goes_on  called several times a second; false ends the wait
  [[nodiscard]] bool wait_for_request(const std::function<bool()>& goes_on);

  /// Whether the present request exceeded its length or time.
  [[nodiscard]] bool is_too_long() const noexcept { return too_long_; }
  [[nodiscard]] bool is_too_slow() const noexcept { return too_slow_; }

  /// Returns the bytes of the present request that were read so far, and keeps no more of it.
  [[nodiscard]] std::string take_head();

  /// Sends a text unless that would block.
  void send_at_once(const std::string& text) const;

  [[nodiscard]] bool is_readable() const override { return begin_ < end_ || wait(POLLIN, request_deadline_); }
  [[nodiscard]] bool is_writable() const override { return wait(POLLOUT, answer_deadline()); }
  ssize_t read(char* bytes, size_t size) override;
  ssize_t write(const char* bytes, size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  [[nodiscard]] socket_t socket() const override { return socket_; }

 private:
  using Clock = std::chrono::steady_clock;
  [[nodiscard]] bool wait(short events, Clock::time_point deadline) const;
  [[nodiscard]] Clock::time_point answer_deadline() const;

  int socket_;
  StreamLimits limits_;
  std::array<char, 4096> buffer_{};
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::size_t left_ = 0;  ///< bytes that the request may still have
  std::string head_;      ///< bytes of the request, until they are taken
  bool keeps_head_ = false;
  bool too_long_ = false;
  bool too_slow_ = false;
  bool has_answered_ = false;
  Clock::time_point request_deadline_;
  Clock::time_point answer_begun_;
  Clock::time_point last_taken_;  ///< some of the answer
  std::size_t written_ = 0;       ///< of the answer
};

}  // namespace eha::web
