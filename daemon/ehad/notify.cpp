// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/notify.hpp"

#include <fmt/format.h>
#include <systemd/sd-daemon.h>

#include <cstdint>
#include <ctime>

namespace eha::service {

Notifier::Notifier() {
  std::uint64_t interval_us = 0;
  has_watchdog_ = sd_watchdog_enabled(0, &interval_us) > 0;
  interval_ = std::chrono::microseconds(interval_us / 4);
}

void Notifier::ready() { sd_notify(0, "READY=1"); }

void Notifier::reloading() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const std::int64_t now_us = static_cast<std::int64_t>(now.tv_sec) * 1'000'000 + now.tv_nsec / 1000;
  sd_notify(0, fmt::format("RELOADING=1\nMONOTONIC_USEC={}", now_us).c_str());
}

void Notifier::stopping() { sd_notify(0, "STOPPING=1"); }

void Notifier::status(const std::string& text) {
  if (text == last_status_) return;
  last_status_ = text;
  sd_notify(0, ("STATUS=" + text).c_str());
}

void Notifier::extend_timeout(std::chrono::seconds time) {
  sd_notify(0, fmt::format("EXTEND_TIMEOUT_USEC={}", std::chrono::microseconds(time).count()).c_str());
}

void Notifier::feed_watchdog() {
  const auto now = std::chrono::steady_clock::now();
  if (!has_watchdog_ || now < next_feed_) return;
  next_feed_ = now + interval_;
  sd_notify(0, "WATCHDOG=1");
}

}  // namespace eha::service
