// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "config/rig_config.hpp"
#include "daemon/worker/worker_process.hpp"

namespace eha::service {

/// Checks submitted experiments, each by `eha check` in a process of its own: computing a table of volts may take
/// minutes, and a process can be limited and killed. Two are on at once, of different users; the next is of the user
/// whose checks took the least time lately, so that nobody waits for all that another one has submitted. Not
/// thread-safe: belongs to the main thread.
class Checker {
 public:
  /// Gets how the check ended; called by poll().
  using Done = std::function<void(const worker::WorkerEnd&)>;
  static constexpr std::chrono::seconds kLongestWork{30};  ///< processor time of one check
  static constexpr std::chrono::seconds kLongestTime{50};  ///< less than the minute that eha waits for an answer
  static constexpr std::size_t kMostAtOnce = 2;            ///< beside an urgent one
  static constexpr std::chrono::minutes kLately{5};

  explicit Checker(worker::WorkerPrograms programs) : programs_(std::move(programs)) {}

  /// What is checked.
  struct Task {
    uid_t user = 0;
    std::filesystem::path experiment;  ///< files; they must stay until `done` is called
    std::filesystem::path rig;
    std::optional<double> place_in = {};  ///< where the rod stands; none: `eha check` assumes [in]
    bool accept_travel_risk = false;      ///< of what the rehearsal would refuse
    std::optional<int> avoided_cpu = {};  ///< the loop's
    bool is_urgent = false;               ///< does not wait for others than urgent ones
  };

  void add(Task task, Done done);

  /// Reports the checks that have ended and starts the next ones. Call on SIGCHLD and about every second.
  void poll();

  /// Kills the checks that are on and forgets the others; their `done` is not called.
  void end() noexcept;

 private:
  using Clock = std::chrono::steady_clock;
  struct Check {
    Task task;
    Done done;
  };
  struct Running {
    Check check;
    std::unique_ptr<worker::WorkerProcess> process;
    Clock::time_point begun;
  };
  struct Spent {
    uid_t user = 0;
    Clock::time_point ended;
    Clock::duration time{};
  };

  /// Reports one that has ended. @returns false without one
  bool report();
  void start(Check check);
  [[nodiscard]] std::deque<Check>::iterator next();
  [[nodiscard]] Clock::duration spent_by(uid_t user) const;

  worker::WorkerPrograms programs_;
  std::deque<Check> waiting_;
  std::vector<Running> running_;
  std::deque<Spent> spent_;  ///< of the checks that ended lately
};

/// The rehearsal in the document that a check has printed, as in the answer of `eha check --json`; null without one.
[[nodiscard]] nlohmann::ordered_json rehearsal_of(const worker::WorkerEnd& end);
/// The experiment's length in the same document [s]; 0 without one.
[[nodiscard]] double duration_of(const worker::WorkerEnd& end);

inline constexpr const char* kCheckedExperiment = "experiment.toml";
inline constexpr const char* kCheckedRig = "rig.toml";

/// Writes the two files of a check into its folder, which is made. @throws IoError, PermissionError
void write_checked_files(const std::filesystem::path& folder, const std::string& experiment,
                         const config::RigConfig& rig);

/// A file that a check reads, and what messages are to call it.
struct CheckedFile {
  std::filesystem::path path;
  std::string name;
};

/// Throws the errors of a failed check.
/// @throws ConfigError  every fault, one a line   @throws Error  with the check's exit code otherwise
void throw_if_failed(const worker::WorkerEnd& end, const CheckedFile& experiment, const CheckedFile& rig);

}  // namespace eha::service
