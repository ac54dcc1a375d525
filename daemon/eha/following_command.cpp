// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include "daemon/doctor/following_estimate.hpp"
#include "daemon/eha/commands.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::cli {
namespace {

/// @throws DataError  the run did not complete, or too much of it was not measured
record::LoadedRun load_completed(const std::filesystem::path& folder) {
  record::LoadedRun run = record::read_run(folder);
  if (run.outcome != acquisition::Outcome::completed) {
    throw DataError(fmt::format("{}: {}; [following] can be estimated from a completed run only", folder.string(),
                                acquisition::to_text(run.outcome)));
  }
  if (100 * run.interpolated_rows > static_cast<std::size_t>(run.record.output.size())) {
    throw DataError(fmt::format("{}: {} of {} rows were not measured, at most 1 % may be; repeat the run",
                                folder.string(), run.interpolated_rows, run.record.output.size()));
  }
  return run;
}

}  // namespace

ExitCode learn_following(const std::filesystem::path& folder, Console& console) {
  const record::LoadedRun run = load_completed(folder);
  const auto values = [](const Eigen::VectorXd& signal) {
    return std::span<const double>(signal.data(), static_cast<std::size_t>(signal.size()));
  };
  const doctor::FollowingEstimate found =
      doctor::estimate_following(values(run.record.input), values(run.record.output), run.record.step_s);
  const config::Following& following = found.following;
  console.print(doctor::to_rig_lines(found));
  console.print_json({{"schema", "eha-following/1"},
                      {"run", run.folder.string()},
                      {"following",
                       {{"gain_positive_in_per_V_s", following.gain_positive_in_per_V_s},
                        {"gain_negative_in_per_V_s", following.gain_negative_in_per_V_s},
                        {"null_V", following.null_V},
                        {"dead_band_V", following.dead_band_V},
                        {"limit_in", following.limit_in}}},
                      {"measured",
                       {{"gain_positive_in_per_V_s", found.gain_in_per_V_s[0]},
                        {"gain_negative_in_per_V_s", found.gain_in_per_V_s[1]},
                        {"dead_band_V", found.dead_band_V},
                        {"null_error_V", found.null_error_V},
                        {"explained_percent", found.explained_percent},
                        {"peak_missing_percent", 100.0 * found.peak_missing},
                        {"peak_excess_percent", 100.0 * found.peak_excess}}}});
  console.info(
      "these lines are for the rig file; add pressure_delay_s if the pressure builds up after the enable line");
  console.next_step("eha check RIG.toml");
  return ExitCode::ok;
}

}  // namespace eha::cli
