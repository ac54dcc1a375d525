// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "daemon/control/client.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {

using Json = control::Json;

/// Longest wait for an event that must happen; a test that waits longer has failed.
inline constexpr std::chrono::seconds kGenerous{200};

/// A file that the service has open without close-on-exec, as libcomedi opens a card.
inline constexpr const char* kDevice = "/dev/zero";
inline constexpr int kDeviceDescriptor = 40;

/// A built `ehad` on the simulated rig with a socket, a state folder and a service manager of its own. When it is
/// started again it finds the files of the one before.
class Daemon {
 public:
  /// @param settings  content of ehad.toml
  /// @param base  of its folder
  explicit Daemon(const std::string& settings = "schema = 1\n",
                  const std::filesystem::path& base = std::filesystem::temp_directory_path());
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;
  ~Daemon();

  /// Gives the ones that are started from here on NAME=VALUE.
  void set_environment(std::string variable) { environment_.push_back(std::move(variable)); }

  /// Sends the messages of the ones that are started from here on to another file; log() does not know it.
  void set_log(std::filesystem::path file) { log_file_ = std::move(file); }

  /// Starts it and returns once it has told its service manager READY=1.
  /// @throws std::runtime_error  it ended instead; with what it said
  void start();
  /// @returns the exit code, 128 + the signal's number when a signal ended it
  int stop(int signal);
  void send(int signal) const;
  int wait();

  [[nodiscard]] pid_t pid() const noexcept { return pid_; }
  [[nodiscard]] std::filesystem::path socket() const { return folder_.path() / "ehad.sock"; }
  [[nodiscard]] std::filesystem::path runs() const { return folder_.path() / "state" / "runs"; }
  [[nodiscard]] std::filesystem::path folder() const { return folder_.path(); }
  [[nodiscard]] std::filesystem::path rig_file() const { return folder_.path() / "rig.toml"; }
  [[nodiscard]] std::string log() const { return content_of(folder_.path() / "log"); }

  /// Waits until the service manager is told a message that contains `text`, after the one it waited for before.
  /// @returns whether that happened in time
  bool hears(const std::string& text, std::chrono::seconds patience = kGenerous);
  /// Discards the messages received so far.
  void forget_messages();
  /// Waits until the log holds `text`. @returns false also once the process has ended without it
  bool logs(const std::string& text, std::chrono::seconds patience = kGenerous) const;

  /// Makes the socket everybody's, as a group with all users in it would.
  void open_to_all() const;

 private:
  [[nodiscard]] bool has_ended() const;
  /// Takes every message at once, as a service manager does: nobody who tells it something may be kept waiting.
  void manage();

  TemporaryFolder folder_;
  int manager_ = -1;  ///< the service manager's end of NOTIFY_SOCKET
  std::mutex mutex_;
  std::condition_variable told_;
  std::deque<std::string> messages_;
  std::thread manager_thread_;
  std::vector<std::string> environment_;
  std::filesystem::path log_file_;
  pid_t pid_ = -1;
};

/// A client that connects as another user (root only).
[[nodiscard]] std::unique_ptr<control::Client> connect_as(uid_t uid, const Daemon& daemon);

/// Whether tests can act as two users here; prints why not.
[[nodiscard]] bool can_change_user();

/// A short experiment on the simulated rig. @param duration_s  a multiple of 0.04 s
[[nodiscard]] std::string experiment_text(const std::string& name, double duration_s = 4.0);
/// One that stays within the valve's dead band, so that the rod stays where it is for as long as one likes.
[[nodiscard]] std::string quiet_experiment_text(const std::string& name, double duration_s);
/// One that drives the rod into its travel limit within a few seconds.
[[nodiscard]] std::string faulting_experiment_text(const std::string& name);

/// Submits an experiment that outlives the client, whatever the rehearsal says of it. @returns its number in the queue
std::int64_t submit(control::Client& client, const std::string& experiment, bool fast = true);

/// Follows an experiment until it is over, or until `enough` says so. @returns its entry then
Json follow(const Daemon& daemon, std::int64_t entry, const std::function<bool(const Json& snapshot)>& enough = {});

/// The code and the message of the refusal; code 0 when it is not refused.
struct Refused {
  int code = 0;
  std::string message;
};
[[nodiscard]] Refused refused(control::Client& client, const std::string& method, const Json& params = Json::object());

/// The entry of a number in the queue as it is now.
[[nodiscard]] Json entry_of(const Daemon& daemon, std::int64_t entry);

}  // namespace eha::test
