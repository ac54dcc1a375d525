// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "core/os/file_descriptor.hpp"
#include "daemon/control/line_buffer.hpp"
#include "daemon/control/protocol.hpp"
#include "daemon/control/socket_path.hpp"

namespace eha::control {

/// The connection ended before the expected answer; the state of ehad is unknown.
class ConnectionLost : public DeviceError {
 public:
  using DeviceError::DeviceError;
};

/// The caller gave up waiting for an answer; the connection is closed, which tells ehad so.
class CallGivenUp : public Error {
 public:
  CallGivenUp() : Error(ExitCode::interrupted, "interrupted while ehad was asked") {}
};

/// A connection to ehad. Blocking. Not thread-safe.
class Client {
 public:
  /// Connects and reads the greeting. ehad answers within milliseconds, unless its disk is slow.
  /// @param patience  for both together
  /// @throws DeviceError      ehad is not running, does not answer, or speaks another protocol
  /// @throws PermissionError  the caller may not use the socket; the message says how to join its group
  explicit Client(const std::filesystem::path& socket, std::chrono::milliseconds patience = std::chrono::minutes(1));
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Sends a request and waits for its answer; drops events of a watch that arrive before it.
  /// @param patience  longest wait for the answer
  /// @param gives_up  asked about five times a second
  /// @throws Error  ehad refused: its code and message   @throws ConnectionLost   @throws CallGivenUp
  Json call(const std::string& method, const Json& params = Json::object(),
            std::chrono::milliseconds patience = std::chrono::minutes(1), const std::function<bool()>& gives_up = {});

  /// Returns the next event of a watch; none after `timeout` or on a signal.
  /// @throws ConnectionLost
  [[nodiscard]] std::optional<Json> next_event(std::chrono::milliseconds timeout);

  /// Process that listens at the socket; none if the kernel does not say.
  [[nodiscard]] std::optional<pid_t> service_process() const noexcept;

  [[nodiscard]] const std::string& version() const noexcept { return version_; }

 private:
  [[nodiscard]] std::optional<Json> next_line(std::chrono::milliseconds timeout);
  [[noreturn]] void lost(const std::string& reason) const;

  std::filesystem::path path_;
  os::FileDescriptor descriptor_;
  LineBuffer input_;
  std::int64_t next_id_ = 1;
  std::string version_;
};

}  // namespace eha::control
