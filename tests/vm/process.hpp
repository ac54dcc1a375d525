// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace eha::test {

/// Who runs a program, and whether somebody types into it.
struct ProcessOptions {
  uid_t user = 0;
  bool is_typed_into = false;  ///< otherwise it has no standard input
};

/// A program of the test machine, killed if it still runs when this goes.
class Process {
 public:
  /// Starts argv[0], found on PATH. @throws std::runtime_error
  explicit Process(const std::vector<std::string>& argv, const ProcessOptions& options = {});
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process();

  /// Waits for its end. @returns its exit code, or 128 + the signal that ended it
  int wait();
  void signal(int number) const;
  /// Types a line. @throws std::runtime_error
  void type(const std::string& line) const;
  [[nodiscard]] pid_t id() const { return id_; }
  /// Its standard output and standard error so far.
  [[nodiscard]] std::string output() const;

 private:
  pid_t id_ = -1;
  int exit_code_ = -1;
  int output_ = -1;  ///< an anonymous file
  int input_ = -1;   ///< of a pipe
};

/// Looks every millisecond until `holds`. @returns whether it did within `patience`
bool wait_until(const std::function<bool()>& holds, std::chrono::milliseconds patience = std::chrono::seconds(30));

}  // namespace eha::test
