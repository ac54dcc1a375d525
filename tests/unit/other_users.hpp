// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sched.h>
#include <sys/resource.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <stdexcept>
#include <vector>

namespace eha::test {

/// Debian's "nobody".
inline constexpr uid_t kOtherUser = 65534;

/// While it lives, this process and what it starts come before what else runs on the machine. Needs root.
class BeforeOthers {
 public:
  BeforeOthers() : before_(getpriority(PRIO_PROCESS, 0)) { setpriority(PRIO_PROCESS, 0, -10); }
  BeforeOthers(const BeforeOthers&) = delete;
  ~BeforeOthers() { setpriority(PRIO_PROCESS, 0, before_); }

 private:
  int before_;
};

/// Processes of another user, which do the same until they are told to end. Needs root.
class OtherUsersStorm {
 public:
  /// @param work  bool(int goes_on): what each does until the pipe `goes_on` has ended, by system calls alone; returns
  ///              whether it could
  template <class Work>
  OtherUsersStorm(int processes, const Work& work) {
    std::array<int, 2> goes_on{};
    if (pipe(goes_on.data()) != 0) throw std::runtime_error("no pipe");
    for (int i = 0; i < processes; ++i) {
      processes_.push_back(fork());
      if (processes_.back() != 0) continue;
      close(goes_on[1]);
      // The unit's weight leaves all users together half of the processors.
      cpu_set_t half;
      CPU_ZERO(&half);
      for (long cpu = 0; cpu < (sysconf(_SC_NPROCESSORS_ONLN) + 1) / 2; ++cpu) CPU_SET(cpu, &half);
      if (sched_setaffinity(0, sizeof half, &half) != 0 || setuid(kOtherUser) != 0) _exit(2);
      _exit(work(goes_on[0]) ? 0 : 1);
    }
    close(goes_on[0]);
    goes_on_ = goes_on[1];
  }
  OtherUsersStorm(const OtherUsersStorm&) = delete;
  ~OtherUsersStorm() { static_cast<void>(all_could()); }

  void let_end() {
    if (goes_on_ >= 0) close(goes_on_);
    goes_on_ = -1;
  }
  /// Whether the first of them is still at it.
  [[nodiscard]] bool goes_on() {
    if (processes_.empty()) return false;
    int status = 0;
    if (waitpid(processes_.front(), &status, WNOHANG) == 0) return true;
    could_ = could_ && status == 0;
    processes_.erase(processes_.begin());
    return false;
  }
  /// Lets them end. @returns whether each could do its work until then
  [[nodiscard]] bool all_could() {
    let_end();
    for (const pid_t process : processes_) {
      int status = 0;
      could_ = waitpid(process, &status, 0) == process && status == 0 && could_;
    }
    processes_.clear();
    return could_;
  }

 private:
  std::vector<pid_t> processes_;
  int goes_on_ = -1;
  bool could_ = true;
};

}  // namespace eha::test
