// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha-safe/watch_parent.hpp"

#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <optional>
#include <string>

namespace eha {
namespace {

constexpr int kPollInterval_ms = 100;
constexpr int kStoppedPolls = 3;  ///< in a row: a debugger that attaches stops a process for milliseconds

/// Recognises the line `done`, byte by byte.
class DoneLine {
 public:
  /// @returns whether the line is complete with this byte
  bool take(char byte) {
    if (byte != '\n') {
      line_ += byte;
      return false;
    }
    const bool is_done = line_ == "done";
    line_.clear();
    return is_done;
  }

 private:
  std::string line_;
};

bool is_stopped(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string stat;
  std::getline(file, stat);
  // "pid (name) state ..."; the name may contain any character.
  const std::size_t name_end = stat.rfind(") ");
  if (name_end == std::string::npos || name_end + 2 >= stat.size()) return false;
  const char state = stat[name_end + 2];
  return state == 'T' || state == 't';
}

/// @returns how the watch ended, if this byte or the end of the stream ended it
std::optional<WatchEnd> take_byte(DoneLine& line) {
  char byte = 0;
  const ssize_t count = read(STDIN_FILENO, &byte, 1);
  if (count < 0 && errno == EINTR) return std::nullopt;
  if (count <= 0) return WatchEnd::death;
  return line.take(byte) ? std::optional(WatchEnd::done) : std::nullopt;
}

/// Reads standard input until nothing comes for one poll interval. @returns how the watch ended, if it did
std::optional<WatchEnd> listen(DoneLine& line) {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  while (poll(&input, 1, kPollInterval_ms) > 0) {
    if (const auto end = take_byte(line)) return end;
  }
  return std::nullopt;
}

}  // namespace

WatchEnd watch_parent() {
  const pid_t parent = getppid();
  DoneLine line;
  int polls_stopped = 0;
  bool was_killed = false;
  for (;;) {
    if (const auto end = listen(line)) return was_killed ? WatchEnd::kill : *end;
    // After the parent's death getppid() names another process; the end of the stream reports the death.
    polls_stopped = getppid() == parent && is_stopped(parent) ? polls_stopped + 1 : 0;
    if (polls_stopped < kStoppedPolls) continue;
    kill(parent, SIGKILL);
    was_killed = true;
    polls_stopped = 0;
  }
}

}  // namespace eha
