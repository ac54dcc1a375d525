// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <string>

namespace eha::service {

/// What the service manager is told (sd_notify(3)); nothing where none started the program. Not thread-safe.
class Notifier {
 public:
  Notifier();

  void ready();
  /// systemd 252 knows no Type=notify-reload: the two halves are sent by hand.
  void reloading();
  void stopping();
  /// One line for `systemctl status`; the same twice is sent once.
  void status(const std::string& text);
  /// Asks for more time to start or stop.
  void extend_timeout(std::chrono::seconds time);
  /// To be called often; the watchdog is fed four times in its interval, so that the manager is not flooded.
  void feed_watchdog();

  /// Whether a watchdog waits to be fed.
  [[nodiscard]] bool has_watchdog() const noexcept { return has_watchdog_; }

 private:
  bool has_watchdog_ = false;
  std::chrono::steady_clock::duration interval_{};
  std::chrono::steady_clock::time_point next_feed_;
  std::string last_status_;
};

}  // namespace eha::service
