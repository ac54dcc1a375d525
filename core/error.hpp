// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace eha {

/// Process exit codes of every program of the project; documented in eha(1).
enum class ExitCode : int {
  ok = 0,
  bug = 1,
  usage = 2,
  model_rejected = 3,
  not_converged = 4,
  bad_data = 10,
  safety_trip = 11,
  deadline = 12,
  device_unavailable = 69,
  io = 74,
  permission = 77,
  configuration = 78,
  interrupted = 130,
};

/// Root of the exceptions for broken input or environment. A message gives what, where, value, limit and
/// next step; it carries no program name and no trailing newline. Legitimate negative outcomes (a rejected
/// model, a search that did not converge) are values, not exceptions.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  [[nodiscard]] ExitCode exit_code() const noexcept { return code_; }

 private:
  ExitCode code_;
};

/// Returns the system's message for an errno value.
[[nodiscard]] inline std::string error_text(int error_number) { return std::generic_category().message(error_number); }

/// A wrong command line.
class UsageError : public Error {
 public:
  explicit UsageError(const std::string& message) : Error(ExitCode::usage, message) {}
};

/// A rig, experiment or model file that cannot be read or whose content is wrong. Holds one line per fault, in
/// the order of the file; what() is the lines joined by newlines. A program prints each line for itself.
class ConfigError : public Error {
 public:
  explicit ConfigError(const std::string& message) : ConfigError(std::vector<std::string>{message}) {}
  /// @param lines at least one
  explicit ConfigError(std::vector<std::string> lines)
      : Error(ExitCode::configuration, joined(lines)), lines_(std::move(lines)) {}
  [[nodiscard]] const std::vector<std::string>& lines() const noexcept { return lines_; }

 private:
  static std::string joined(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += (text.empty() ? "" : "\n") + line;
    return text;
  }

  std::vector<std::string> lines_;
};

/// Throws ConfigError(message) unless the condition holds.
inline void require(bool condition, const std::string& message) {
  if (!condition) throw ConfigError(message);
}

/// A record that cannot be used.
class DataError : public Error {
 public:
  explicit DataError(const std::string& message) : Error(ExitCode::bad_data, message) {}
};

/// A device that is absent, refuses a call, or does not match the rig file.
class DeviceError : public Error {
 public:
  explicit DeviceError(const std::string& message) : Error(ExitCode::device_unavailable, message) {}
};

/// A file that cannot be read or written.
class IoError : public Error {
 public:
  explicit IoError(const std::string& message) : Error(ExitCode::io, message) {}
};

/// An operation that the caller has no permission for.
class PermissionError : public Error {
 public:
  explicit PermissionError(const std::string& message) : Error(ExitCode::permission, message) {}
};

}  // namespace eha
