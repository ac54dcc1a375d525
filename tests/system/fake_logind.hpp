// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <systemd/sd-bus.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "tests/system/daemon.hpp"
#include "tests/system/program.hpp"

namespace eha::test {

/// A message bus of its own with a stand-in for logind, which hands out inhibitors and announces a suspend.
class FakeLogind {
 public:
  explicit FakeLogind(const std::filesystem::path& folder) : address_("unix:path=" + (folder / "bus").string()) {
    std::ofstream(folder / "bus.conf")
        << "<busconfig><listen>" << address_
        << "</listen><policy context=\"default\"><allow user=\"*\"/><allow own=\"*\"/>"
           "<allow send_destination=\"*\" eavesdrop=\"true\"/><allow eavesdrop=\"true\"/></policy></busconfig>";
    std::string program = "dbus-daemon";
    std::string nofork = "--nofork";
    std::string config = "--config-file=" + (folder / "bus.conf").string();
    std::array<char*, 4> arguments{program.data(), nofork.data(), config.data(), nullptr};
    if (posix_spawnp(&daemon_, program.c_str(), nullptr, nullptr, arguments.data(), environ) != 0) return;
    const auto deadline = std::chrono::steady_clock::now() + kGenerous;
    while (!connect() && std::chrono::steady_clock::now() < deadline)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  FakeLogind(const FakeLogind&) = delete;
  FakeLogind& operator=(const FakeLogind&) = delete;
  ~FakeLogind() {
    sd_bus_flush_close_unref(bus_);
    if (inhibitor_ >= 0) close(inhibitor_);
    if (daemon_ <= 0) return;
    kill(daemon_, SIGKILL);
    waitpid(daemon_, nullptr, 0);
  }

  [[nodiscard]] bool works() const { return bus_ != nullptr; }
  [[nodiscard]] std::string address() const { return address_; }
  [[nodiscard]] std::string asked() const { return asked_; }

  /// Whether a bus can be had here.
  [[nodiscard]] static bool is_possible() { return !output_of_shell("command -v dbus-daemon").empty(); }

  /// Serves until the inhibitor is held, or is not. @returns whether that came in time
  bool await_held(bool wanted) {
    const auto deadline = std::chrono::steady_clock::now() + kGenerous;
    while (is_held() != wanted && std::chrono::steady_clock::now() < deadline) {
      while (sd_bus_process(bus_, nullptr) > 0) {
      }
      sd_bus_wait(bus_, 50'000);
    }
    return is_held() == wanted;
  }
  void announce_sleep() {
    sd_bus_emit_signal(bus_, "/org/freedesktop/login1", kInterface, "PrepareForSleep", "b", 1);
    sd_bus_flush(bus_);
  }

  /// What a user who is not root sends to the connection that has asked for the inhibitor. @returns whether it was sent
  bool forge_sleep(uid_t uid) const {
    const pid_t forger = fork();
    if (forger == 0) _exit(setuid(uid) == 0 && sends_sleep() ? 0 : 1);
    int status = -1;
    return forger > 0 && waitpid(forger, &status, 0) == forger && status == 0;
  }

 private:
  static constexpr const char* kInterface = "org.freedesktop.login1.Manager";

  bool connect() {
    sd_bus* bus = nullptr;
    sd_bus_new(&bus);
    sd_bus_set_address(bus, address_.c_str());
    sd_bus_set_bus_client(bus, 1);
    if (sd_bus_start(bus) < 0 || sd_bus_request_name(bus, "org.freedesktop.login1", 0) < 0) {
      sd_bus_close_unref(bus);
      return false;
    }
    static const sd_bus_vtable table[] = {SD_BUS_VTABLE_START(0),
                                          SD_BUS_METHOD("Inhibit", "ssss", "h", &FakeLogind::on_inhibit, 0),
                                          SD_BUS_SIGNAL("PrepareForSleep", "b", 0), SD_BUS_VTABLE_END};
    sd_bus_add_object_vtable(bus, nullptr, "/org/freedesktop/login1", kInterface, table, this);
    bus_ = bus;
    return true;
  }
  [[nodiscard]] bool sends_sleep() const {
    sd_bus* bus = nullptr;
    sd_bus_message* signal = nullptr;
    sd_bus_new(&bus);
    sd_bus_set_address(bus, address_.c_str());
    sd_bus_set_bus_client(bus, 1);
    const bool is_sent =
        sd_bus_start(bus) >= 0 &&
        sd_bus_message_new_signal(bus, &signal, "/org/freedesktop/login1", kInterface, "PrepareForSleep") >= 0 &&
        sd_bus_message_append(signal, "b", 1) >= 0 && sd_bus_message_set_destination(signal, asker_.c_str()) >= 0 &&
        sd_bus_send(bus, signal, nullptr) >= 0 && sd_bus_flush(bus) >= 0;
    sd_bus_message_unref(signal);
    sd_bus_flush_close_unref(bus);
    return is_sent;
  }
  static int on_inhibit(sd_bus_message* message, void* object, sd_bus_error*) {
    auto* self = static_cast<FakeLogind*>(object);
    std::array<const char*, 4> words{};
    sd_bus_message_read(message, "ssss", &words[0], &words[1], &words[2], &words[3]);
    self->asker_ = sd_bus_message_get_sender(message);
    self->asked_ = std::string(words[0]) + " " + words[3];
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) return -errno;
    self->inhibitor_ = ends[0];
    const int result = sd_bus_reply_method_return(message, "h", ends[1]);
    close(ends[1]);
    return result;
  }
  /// Whether anybody has the other end open.
  [[nodiscard]] bool is_held() const {
    pollfd end{inhibitor_, 0, 0};
    return inhibitor_ >= 0 && poll(&end, 1, 0) == 0;
  }

  std::string address_;
  std::string asked_;
  std::string asker_;  ///< name of its connection
  pid_t daemon_ = -1;
  sd_bus* bus_ = nullptr;
  int inhibitor_ = -1;
};

}  // namespace eha::test
