// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <string>

namespace eha::service {

/// Sends messages to the service manager (sd_notify(3)); does nothing if none started the program. Not thread-safe.
class Notifier {
 public:
  Notifier();

  void ready();
  /// systemd 252 lacks Type=notify-reload, so RELOADING=1 and READY=1 are sent here.
  void reloading();
  void stopping();
  /// One line for `systemctl status`; sent when it differs from the last one.
  void status(const std::string& text);
  /// Requests more time to start or stop.
  void extend_timeout(std::chrono::seconds time);
  /// Call often; feeds the watchdog at most four times in its interval.
  void feed_watchdog();

  /// Whether the service manager expects watchdog messages.
  [[nodiscard]] bool has_watchdog() const noexcept { return has_watchdog_; }

 private:
  bool has_watchdog_ = false;
  std::chrono::steady_clock::duration interval_{};
  std::chrono::steady_clock::time_point next_feed_;
  std::string last_status_;
};

}  // namespace eha::service
