// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha-safe/watch_parent.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string_view>

#include "core/priorities.hpp"
#include "daemon/eha-safe/stall_watch.hpp"

namespace eha {
namespace {

constexpr std::int64_t kIdleLook_ns = 50'000'000;  ///< less than the time from enable to the first motion
constexpr std::int64_t kStopLook_ns = 100'000'000;
constexpr int kStoppedLooks = 3;  ///< in a row: a debugger that attaches stops a process for milliseconds
/// A loop that recovers within this time ends its run and saves its record itself. On a card that does not answer the
/// last tick makes three calls of about 1 s each.
constexpr std::int64_t kReturn_ns = 3'500'000'000;

std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// Recognises the line `done`, byte by byte.
class DoneLine {
 public:
  /// @returns whether the line is complete with this byte
  bool take(char byte) {
    if (byte != '\n') {
      matches_ = matches_ && length_ < kDone.size() && kDone[length_] == byte;
      ++length_;
      return false;
    }
    const bool is_done = matches_ && length_ == kDone.size();
    matches_ = true;
    length_ = 0;
    return is_done;
  }

 private:
  static constexpr std::string_view kDone = "done";
  bool matches_ = true;
  std::size_t length_ = 0;
};

bool is_stopped(pid_t process) {
  std::array<char, 64> path{};
  std::snprintf(path.data(), path.size(), "/proc/%d/stat", process);
  const int file = open(path.data(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  std::array<char, 512> text{};
  const ssize_t size = read(file, text.data(), text.size() - 1);
  close(file);
  // "pid (name) state ..."; the name may contain any character.
  const std::string_view stat(text.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  const std::size_t name_end = stat.rfind(") ");
  if (name_end == std::string_view::npos || name_end + 2 >= stat.size()) return false;
  const char state = stat[name_end + 2];
  return state == 'T' || state == 't';
}

/// One byte of standard input, and the descriptor that came with it. @returns as read()
ssize_t receive(char& byte, os::FileDescriptor& descriptor) {
  iovec place{.iov_base = &byte, .iov_len = 1};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr message{};
  message.msg_iov = &place;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t count = recvmsg(STDIN_FILENO, &message, MSG_CMSG_CLOEXEC);
  if (count < 0 && errno == ENOTSOCK) return read(STDIN_FILENO, &byte, 1);
  const cmsghdr* const header = count > 0 ? CMSG_FIRSTHDR(&message) : nullptr;
  if (header != nullptr && header->cmsg_type == SCM_RIGHTS) {
    int received = -1;
    std::memcpy(&received, CMSG_DATA(header), sizeof received);
    descriptor = os::FileDescriptor(received);
  }
  return count;
}

/// Reads standard input until nothing arrives for the given time. @returns the reason for the watch's end, if it ended
std::optional<WatchEnd> listen(DoneLine& line, std::int64_t patience_ns, os::FileDescriptor& descriptor) {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  const timespec patience{.tv_sec = 0, .tv_nsec = static_cast<long>(patience_ns)};
  while (ppoll(&input, 1, &patience, nullptr) > 0) {
    char byte = 0;
    const ssize_t count = receive(byte, descriptor);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return WatchEnd::death;
    if (line.take(byte)) return WatchEnd::done;
  }
  return std::nullopt;
}

/// Lets a thread of this user (0: this one) run on every processor.
void free_affinity(pid_t thread) {
  cpu_set_t all;
  CPU_ZERO(&all);
  for (std::size_t cpu = 0; cpu < CPU_SETSIZE; ++cpu) CPU_SET(cpu, &all);
  sched_setaffinity(thread, sizeof all, &all);
}

/// Gives a real-time thread of this user a priority, if it is allowed.
bool set_priority(pid_t thread, int priority) {
  sched_param parameter{};
  parameter.sched_priority = priority;
  return sched_setscheduler(thread, SCHED_FIFO, &parameter) == 0;
}

/// Lets a loop that another process starves continue, if only to end its run: on any processor, just below the guard.
/// The loop may also hold the card's mutex in the kernel, for which the guard would wait.
void bring_back(pid_t loop) {
  free_affinity(loop);
  set_priority(loop, kGuardPriority - 1);
}

/// Acts on a stalled loop.
class StallGuard {
 public:
  explicit StallGuard(const Watched& watched) : watched_(watched) {}

  [[nodiscard]] bool is_driven() const { return acts() && GuardPage::is_driven(drive()); }

  /// @returns whether the process must be killed
  bool look() {
    if (!acts()) return false;
    const std::uint32_t drive = this->drive();
    const std::int64_t stalled_ns = watch_.look(drive, watched_.page->beats(), now_ns());
    if (drive != tripped_) is_off_ = false;
    const std::int64_t limit_ns = watched_.page->stall_limit_ns();
    if (!GuardPage::is_driven(drive) || stalled_ns <= limit_ns) return false;
    if (drive != tripped_) {
      tripped_ = drive;
      // Set first, so that a loop that recovers now makes the rig safe itself.
      watched_.page->trip(drive);
      bring_back(watched_.page->loop_thread());
    }
    if (!is_off_) is_off_ = watched_.switch_off && watched_.switch_off();
    // Without an enable line only the death of the process frees the output.
    return !watched_.switch_off || stalled_ns > limit_ns + kReturn_ns;
  }

 private:
  [[nodiscard]] bool acts() const { return watched_.page != nullptr && watched_.drives_machine; }
  [[nodiscard]] std::uint32_t drive() const { return watched_.page->drive(); }

  const Watched& watched_;
  StallWatch watch_;
  std::uint32_t tripped_ = 0;
  bool is_off_ = false;
};

void be_spared_when_memory_is_short() {
  const int file = open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
  if (file < 0) return;
  // Refused without the privilege; then the value of the service unit applies.
  constexpr std::string_view kSpared = "-900\n";
  [[maybe_unused]] const ssize_t written = write(file, kSpared.data(), kSpared.size());
  close(file);
}

}  // namespace

void become_guard() noexcept {
  free_affinity(0);
  rlimit highest{};
  if (!set_priority(0, kGuardPriority) && getrlimit(RLIMIT_RTPRIO, &highest) == 0) {
    set_priority(0, static_cast<int>(std::min<rlim_t>(highest.rlim_cur, kGuardPriority)));
  }
  // Under a finite limit a later allocation would fail.
  rlimit locked{};
  if (geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &locked) == 0 && locked.rlim_cur == RLIM_INFINITY)) {
    mlockall(MCL_CURRENT | MCL_FUTURE);
  }
  be_spared_when_memory_is_short();
}

WatchEnd watch_parent(Watched& watched) {
  const pid_t parent = getppid();
  DoneLine line;
  StallGuard stall(watched);
  int stopped_looks = 0;
  std::int64_t next_stop_look_ns = now_ns() + kStopLook_ns;
  std::optional<WatchEnd> killed;
  for (;;) {
    const std::int64_t patience_ns = stall.is_driven() ? StallWatch::kLook_ns : kIdleLook_ns;
    if (const auto end = listen(line, patience_ns, watched.journal)) return killed.value_or(*end);
    bool must_die = stall.look();
    WatchEnd reason = WatchEnd::stall;
    // The run is over, or there are no rows to save: releases the journal.
    if (watched.journal && (watched.page == nullptr || !watched.page->has_journal())) watched.journal.close();
    if (const std::int64_t now = now_ns(); now >= next_stop_look_ns) {
      next_stop_look_ns = now + kStopLook_ns;
      stopped_looks = is_stopped(parent) ? stopped_looks + 1 : 0;
      if (stopped_looks >= kStoppedLooks) {
        must_die = true;
        reason = WatchEnd::stop;
      }
    }
    // After the parent's death getppid() names another process; the end of the stream reports the death.
    if (!must_die || getppid() != parent) continue;
    kill(parent, SIGKILL);
    killed = reason;
    stopped_looks = 0;
  }
}

}  // namespace eha
