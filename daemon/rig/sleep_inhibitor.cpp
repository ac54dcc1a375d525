// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/sleep_inhibitor.hpp"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <systemd/sd-bus.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <utility>

#include "core/error.hpp"
#include "daemon/acquisition/fatal_signals.hpp"

namespace eha {
namespace {

constexpr std::uint64_t kCallLimit_us = 1'000'000;
constexpr int kLongestPoll_ms = 1000;
constexpr int kMostAtOnce = 64;
constexpr const char* kService = "org.freedesktop.login1";
constexpr const char* kPath = "/org/freedesktop/login1";
constexpr const char* kInterface = "org.freedesktop.login1.Manager";

/// A connection to logind and the inhibitor, both used by one thread.
class Logind {
 public:
  explicit Logind(std::function<void()> about_to_sleep) : about_to_sleep_(std::move(about_to_sleep)) {}
  Logind(const Logind&) = delete;
  Logind& operator=(const Logind&) = delete;
  ~Logind() {
    release();
    sd_bus_flush_close_unref(bus_);
  }

  /// @returns empty if suspends will be announced, otherwise the reason
  std::string connect() {
    int result = sd_bus_open_system(&bus_);
    if (result < 0) return error_text(-result);
    sd_bus_set_method_call_timeout(bus_, kCallLimit_us);
    result =
        sd_bus_match_signal(bus_, nullptr, kService, kPath, kInterface, "PrepareForSleep", &Logind::on_sleep, this);
    return result < 0 ? error_text(-result) : "";
  }

  /// @returns empty if the inhibitor is held, otherwise the reason
  std::string inhibit(const std::string& program) {
    sd_bus_message* reply = nullptr;
    sd_bus_error error = SD_BUS_ERROR_NULL;
    int result = sd_bus_call_method(bus_, kService, kPath, kInterface, "Inhibit", &error, &reply, "ssss", "sleep",
                                    program.c_str(), "a rig is driven", "delay");
    std::string message = result < 0 && error.message != nullptr ? error.message : "";
    int descriptor = -1;
    if (result >= 0) result = sd_bus_message_read(reply, "h", &descriptor);
    if (result >= 0) inhibitor_ = os::FileDescriptor(fcntl(descriptor, F_DUPFD_CLOEXEC, 0));
    sd_bus_error_free(&error);
    sd_bus_message_unref(reply);
    if (result < 0 && message.empty()) message = error_text(-result);
    return message;
  }

  void release() { inhibitor_.close(); }
  [[nodiscard]] bool is_held() const { return static_cast<bool>(inhibitor_); }

  /// Handles received messages. @returns a negative errno if the connection is lost
  int process() {
    int result = 1;
    // Anybody may send messages without end.
    for (int count = 0; count < kMostAtOnce && result > 0; ++count) result = sd_bus_process(bus_, nullptr);
    return result;
  }
  [[nodiscard]] pollfd events() const { return {sd_bus_get_fd(bus_), static_cast<short>(sd_bus_get_events(bus_)), 0}; }

 private:
  static int on_sleep(sd_bus_message* message, void* self, sd_bus_error*) {
    int begins = 0;
    const bool is_told = sd_bus_message_read(message, "b", &begins) >= 0 && begins != 0;
    if (is_told && is_trusted(message)) static_cast<Logind*>(self)->about_to_sleep_();
    return 0;
  }

  /// Whether root, as logind is, or this user sent a message: the bus delivers anybody's signal that is addressed to
  /// this connection.
  static bool is_trusted(sd_bus_message* message) {
    sd_bus_creds* sender = nullptr;
    uid_t uid = 0;
    const int asked = sd_bus_query_sender_creds(message, SD_BUS_CREDS_EUID, &sender);
    if (asked == -ETIMEDOUT) return true;  // a bus that is busy: rather one ramp too many
    const bool is_known = asked >= 0 && sd_bus_creds_get_euid(sender, &uid) >= 0;
    sd_bus_creds_unref(sender);
    return is_known && (uid == 0 || uid == geteuid());
  }

  std::function<void()> about_to_sleep_;
  sd_bus* bus_ = nullptr;
  os::FileDescriptor inhibitor_;
};

}  // namespace

std::string undelayed_suspend_text(const std::string& why) {
  return "a suspend of the machine cannot be delayed during a run: " + why +
         "; to forbid suspends: systemctl mask sleep.target";
}

SleepInhibitor::SleepInhibitor(std::string program, Events events)
    : program_(std::move(program)), events_(std::move(events)), wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!wake_) throw IoError("cannot create an event descriptor: " + error_text(errno));
  thread_ = std::thread([this] { run(); });
  pthread_setname_np(thread_.native_handle(), "eha-sleep");
}

SleepInhibitor::~SleepInhibitor() {
  ending_ = true;
  static_cast<void>(eventfd_write(wake_.get(), 1));
  thread_.join();
}

void SleepInhibitor::want(bool held) noexcept {
  if (wanted_.exchange(held) != held) static_cast<void>(eventfd_write(wake_.get(), 1));
}

void SleepInhibitor::run() {
  acquisition::block_all_but_fatal_signals();
  Logind logind(events_.about_to_sleep);
  const auto wait = [this](pollfd bus) {
    std::array<pollfd, 2> waiting{bus, pollfd{wake_.get(), POLLIN, 0}};
    poll(waiting.data(), waiting.size(), kLongestPoll_ms);
    eventfd_t count = 0;
    static_cast<void>(eventfd_read(wake_.get(), &count));
  };
  // The bus is not needed before the first run.
  while (!ending_ && !wanted_) wait({-1, 0, 0});
  std::string fault = ending_ ? "" : logind.connect();
  while (!ending_ && fault.empty()) {
    if (wanted_ && !logind.is_held()) fault = logind.inhibit(program_);
    if (!wanted_) logind.release();
    if (fault.empty() && logind.process() < 0) fault = "the connection to the system bus is lost";
    if (fault.empty()) wait(logind.events());
  }
  if (!fault.empty()) events_.unavailable(fault);
}

}  // namespace eha
