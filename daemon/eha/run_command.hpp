// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "daemon/eha/drive_options.hpp"

namespace eha::cli {

class Console;

/// Name of the experiment that `eha characterise` plays.
inline constexpr const char* kCharacterising = "characterise";

struct RunCommand : DriveOptions {
  std::string experiment_file = {};
  std::vector<std::string> further_files = {};  ///< played after the first one, in order
  std::optional<std::string> text = {};         ///< of the experiment; none: experiment_file is read
  std::string controller_file = {};             ///< whose trial is played; empty: none
  std::string controller_model = {};            ///< that it was made of
  bool detach = false;                          ///< queue without waiting
  bool accept_travel_risk = false;              ///< play even if the rehearsal refuses
  std::optional<std::string> ruler = {};        ///< reading of a ruler at the rod, for [characterise]; none: asked for
  std::optional<std::filesystem::path> new_rig_file = {};  ///< to write with the numbers of a valve sheet
  std::optional<double> simulated_tick_s = {};  ///< of a simulated rig in this process, instead of its file's
};

[[nodiscard]] ExitCode execute(const RunCommand& command, Console& console);

/// An error of one of several experiments, from before the first motion, and what became of the list.
class ListError : public Error {
 public:
  /// @param outcome  such as "none of the 2 experiments was played"
  ListError(const Error& error, std::string outcome)
      : Error(error.exit_code(), std::string(error.what()) + "\n" + outcome), outcome_(std::move(outcome)) {}
  [[nodiscard]] const std::string& outcome() const noexcept { return outcome_; }

 private:
  std::string outcome_;
};

/// Throws the error again that is handled now; with several experiments as a ListError.
/// @param outcome  what none of them was, such as "played"
[[noreturn]] inline void rethrow_of_list(const Error& error, const RunCommand& command, const std::string& outcome) {
  if (command.further_files.empty()) throw;
  throw ListError(error,
                  "none of the " + std::to_string(1 + command.further_files.size()) + " experiments was " + outcome);
}

/// Runs `work`, which precedes the first motion, and passes on its errors with rethrow_of_list().
template <class Work>
auto as_a_list(const RunCommand& command, const char* outcome, const Work& work) {
  try {
    return work();
  } catch (const Error& error) {
    rethrow_of_list(error, command, outcome);
  }
}

}  // namespace eha::cli
