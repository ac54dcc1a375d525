// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "daemon/control/socket_path.hpp"
#include "daemon/eha/console.hpp"

namespace eha::cli {

/// Options of `eha commission`.
struct CommissionOptions {
  std::string rig_file;
  std::filesystem::path folder = "commission";
  std::filesystem::path socket = control::default_socket();
  bool local = false;
  bool fast = false;
  bool yes = false;
  bool allow_non_realtime = false;
  double precision_percent = 2.0;
  std::optional<std::string> ruler = {};
};

/// Returns the command that continues a commissioning.
[[nodiscard]] std::string again(const CommissionOptions& command);

/// Stops a commissioning; completed steps are kept.
struct Stopped {
  ExitCode code;
  std::string why;
  std::string next = {};  ///< what to do; empty: the same command goes on with this step
};

/// Whether the results of a step's command are printed; with --verbose they always are.
enum class Results { show, hide };

/// Result of a step's command.
struct Played {
  nlohmann::ordered_json document;
  ExitCode code;
};

/// Asks the user, and executes the command lines of a commissioning's steps in this process. While one lives, a signal
/// that ends the process first prints the command that continues; one object at a time.
class CommissionSession {
 public:
  /// @param moves_machine  whether the rig moves a machine
  CommissionSession(const CommissionOptions& command, bool moves_machine, Console& console);
  CommissionSession(const CommissionSession&) = delete;
  CommissionSession& operator=(const CommissionSession&) = delete;
  ~CommissionSession();

  /// Whether this process drives the rig.
  [[nodiscard]] bool is_local() const noexcept { return is_local_; }

  /// Announces the next step and its effect on the rod.
  void announce(const std::string& step, const std::string& does) const;
  /// @throws Stopped  the answer is not yes; not with --yes
  void ask() const;
  /// The same before a motion. For a machine the step's command itself asks.
  void ask_before_motion() const;

  /// @throws Stopped  the command threw an Error, which is printed
  Played play(std::vector<std::string> words, Results results = Results::show);
  /// The same for a command that drives the rig; through the service, it arms the rig before.
  Played drive(std::vector<std::string> words, Results results = Results::show);
  /// Disarms a machine that drive() armed; ignores errors of the service.
  void disarm() noexcept;

 private:
  const CommissionOptions& command_;
  Console& console_;
  bool moves_machine_;
  bool is_local_;
  bool is_armed_ = false;
};

}  // namespace eha::cli
