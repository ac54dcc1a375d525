// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>

#include "core/os/file_descriptor.hpp"
#include "daemon/ehad/background.hpp"

namespace eha::service {

/// Delays a suspend of the machine during a run until the run has ramped out: takes logind's delay inhibitor
/// (org.freedesktop.login1, Inhibit "sleep" "delay"), and calls back when a suspend is announced. A separate thread
/// uses the bus, so that a slow or missing logind delays nothing. Belongs to the main thread.
class SleepInhibitor {
 public:
  /// Notifications of the service, in the main thread.
  struct Events {
    std::function<void()> about_to_sleep;                 ///< a suspend waits for the release
    std::function<void(const std::string&)> unavailable;  ///< called once, with the reason: no suspend can be delayed
  };

  SleepInhibitor(Mailbox& mailbox, Events events);
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

  Mailbox& mailbox_;
  Events events_;
  std::atomic<bool> wanted_{false};
  std::atomic<bool> ending_{false};
  os::FileDescriptor wake_;  ///< eventfd: wanted_ or ending_ has changed
  std::thread thread_;
};

}  // namespace eha::service
