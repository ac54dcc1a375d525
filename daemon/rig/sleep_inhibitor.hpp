// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>

#include "core/os/file_descriptor.hpp"

namespace eha {

/// Warns of a suspend that nothing delays, and says how to forbid it.
[[nodiscard]] std::string undelayed_suspend_text(const std::string& why);

/// Delays a suspend of the machine during a run until the run has ramped out: takes logind's delay inhibitor
/// (org.freedesktop.login1, Inhibit "sleep" "delay"), and calls back when a suspend is announced. A separate thread
/// uses the bus, so that a slow or missing logind delays nothing.
class SleepInhibitor {
 public:
  /// Called in that thread.
  struct Events {
    std::function<void()> about_to_sleep;                 ///< a suspend waits for the release
    std::function<void(const std::string&)> unavailable;  ///< called once, with the reason: no suspend can be delayed
  };

  /// @param program  name under which `systemd-inhibit --list` shows the delay
  SleepInhibitor(std::string program, Events events);
  SleepInhibitor(const SleepInhibitor&) = delete;
  SleepInhibitor& operator=(const SleepInhibitor&) = delete;
  /// Releases the inhibitor; returns within a second.
  ~SleepInhibitor();

  /// Takes or releases the inhibitor soon. Return at once; have no effect if it is already so.
  void hold() noexcept { want(true); }
  void release() noexcept { want(false); }

 private:
  void want(bool held) noexcept;
  void run();

  std::string program_;
  Events events_;
  std::atomic<bool> wanted_{false};
  std::atomic<bool> ending_{false};
  os::FileDescriptor wake_;  ///< eventfd: wanted_ or ending_ has changed
  std::thread thread_;
};

}  // namespace eha
