// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <deque>
#include <exception>
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

/// Checks submitted experiments, each by `eha check` in its own process: computing a table of volts may take minutes,
/// and a process can be limited and killed. Two checks run at once, of different users. The next check is of the user
/// whose checks took the least time recently, so that no user waits for another one's many submissions. Not
/// thread-safe: belongs to the main thread.
class Checker {
 public:
  /// Receives the end of the check; called by poll().
  using Done = std::function<void(const worker::WorkerEnd&)>;
  static constexpr std::chrono::seconds kLongestWork{30};  ///< processor time of one check
  static constexpr std::chrono::seconds kLongestTime{50};  ///< less than the minute for which eha waits for an answer
  static constexpr std::size_t kMostAtOnce = 2;            ///< in addition to an urgent one
  static constexpr std::chrono::minutes kLately{5};

  explicit Checker(worker::WorkerPrograms programs) : programs_(std::move(programs)) {}

  /// A check to run.
  struct Task {
    uid_t user = 0;
    std::filesystem::path experiment;  ///< files; they must stay until `done` is called
    std::filesystem::path rig;
    std::optional<double> place_in = {};  ///< position of the rod; none: `eha check` assumes one [in]
    bool accept_travel_risk = false;      ///< accept the risk for which the rehearsal would refuse
    std::optional<int> avoided_cpu = {};  ///< CPU of the loop
    bool is_urgent = false;               ///< waits for urgent checks only
  };

  void add(Task task, Done done);

  /// Reports the checks that have ended and starts the next ones. Call on SIGCHLD and about every second.
  void poll();

  /// Kills the running checks and drops the others; their `done` is not called.
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

  /// Reports one that has ended. @returns false if there is none
  bool report();
  void start(Check check);
  [[nodiscard]] std::deque<Check>::iterator next();
  [[nodiscard]] Clock::duration spent_by(uid_t user) const;

  worker::WorkerPrograms programs_;
  std::deque<Check> waiting_;
  std::vector<Running> running_;
  std::deque<Spent> spent_;  ///< checks that ended recently
};

/// Returns the rehearsal in the document that a check printed, as in `eha check --json`; null without one.
[[nodiscard]] nlohmann::ordered_json rehearsal_of(const worker::WorkerEnd& end);
/// Returns the experiment's length in the same document [s]; 0 without one.
[[nodiscard]] double duration_of(const worker::WorkerEnd& end);

inline constexpr const char* kCheckedExperiment = "experiment.toml";
inline constexpr const char* kCheckedRig = "rig.toml";

/// Writes the two files of a check into its folder, which it creates. @throws IoError, PermissionError
void write_checked_files(const std::filesystem::path& folder, const std::string& experiment,
                         const config::RigConfig& rig);

/// A file that a check reads, and its name in messages.
struct CheckedFile {
  std::filesystem::path path;
  std::string name;
};

/// What the checks of a list found. One that was not done in time does not end them: another experiment's fault is
/// named beside it. A second one does, as each may take kLongestTime.
class ListFindings {
 public:
  /// Takes the end of a check. @returns whether the next experiment is worth one
  [[nodiscard]] bool take(const worker::WorkerEnd& end, const CheckedFile& experiment, const CheckedFile& rig);
  /// @throws as throw_if_failed()  of the fault, with a line on the check that was not done
  void throw_if_any() const;

 private:
  std::exception_ptr fault_;
  std::exception_ptr not_checked_;
};

/// Throws the errors of a failed check.
/// @throws ConfigError  every fault, one a line   @throws Error  with the check's exit code otherwise
void throw_if_failed(const worker::WorkerEnd& end, const CheckedFile& experiment, const CheckedFile& rig);

}  // namespace eha::service
