// SPDX-License-Identifier: GPL-3.0-or-later
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "config/controller_config.hpp"
#include "config/file_kind.hpp"
#include "config/track_text.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/commands.hpp"
#include "daemon/eha/drive_options.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/eha/run_command.hpp"
#include "daemon/eha/track_report.hpp"
#include "daemon/track/track_result.hpp"

namespace eha::cli {
namespace {

constexpr const char* kTrackFooter = R"(
Plays the trial of a controller (a file of `eha tune`) on a simulated rig, in closed loop: a step, trapezoids as fast as the
reference may move, a sine and a hold of 20 s. It is a run like any other: every limit of the rig file holds, Ctrl-C ramps
out, and the way is recorded. Nothing of the controller stays in force after it. It is a fault when the rod follows worse
(following_error) or the command swings more often (oscillation) than the controller's file allows. Prints what was
measured beside what was promised, and writes track.json and track.csv into the run folder.
A controller made for another rig, tick or travel is refused. Controllers are not played on a machine yet.
With RUN, the figures of an earlier run are computed again; nothing moves. Exit code 3: the promise is not kept.

Examples:
  eha track axis.toml --local --fast
  eha track runs/20260101T120000Z-track-axis
  eha plot runs/20260101T120000Z-track-axis/track.csv -o track.png)";

struct TrackCommand : DriveOptions {
  std::string source;  ///< controller file or run folder
  config::TrackedMotion motion = {};
};

}  // namespace

ExitCode show_track(const std::filesystem::path& folder, TrackFiles wanted, const Console& console) {
  const track::TrackResult result = track::track_result(folder);
  if (wanted == TrackFiles::write) track::write_track(result);
  const ExitCode code = result.is_kept() ? ExitCode::ok : ExitCode::model_rejected;
  nlohmann::ordered_json document = track::to_json(result);
  document["exit_code"] = static_cast<int>(code);
  console.print_json(document);
  console.print(track::track_text(result));
  console.next_step("eha plot " + shell_word((result.folder / track::kTrackRows).string()));
  return code;
}

ExitCode execute(const TrackCommand& command, Console& console) {
  std::error_code ignored;
  if (std::filesystem::is_directory(command.source, ignored)) {
    return show_track(command.source, TrackFiles::keep, console);
  }
  RunCommand run{command};
  run.experiment_file = "track " + command.source;
  const std::string text = config::read_config_file(command.source);
  run.text = config::track_experiment(config::parse_controller(text, command.source).name, text, command.motion);
  return execute(run, console);
}

void add_track(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("track", "Play a controller's trial, and hold it to its promise");
  sub->footer(kTrackFooter);
  auto& track = options_of<TrackCommand>(*sub, line);
  const auto positive = [] { return finite_number("a positive number", [](double x) { return x > 0.0; }); };
  sub->add_option("source", track.source, "Controller file, or the run folder of an earlier trial")
      ->required()
      ->type_name("CONTROLLER|RUN");
  sub->add_option("--step", track.motion.step_in, "Way of the step and the trapezoids [in]")
      ->type_name("IN")
      ->check(positive());
  sub->add_option("--sine", track.motion.sine_in, "Amplitude of the sine [in]")->type_name("IN")->check(positive());
  sub->add_option("--frequency", track.motion.sine_Hz, "Frequency of the sine [Hz]")
      ->type_name("HZ")
      ->check(positive());
  sub->add_option("--hold", track.motion.hold_s, "Duration of the hold (default 20 s)")
      ->type_name("SECONDS")
      ->check(positive());
  add_drive_options(*sub, track);
}

}  // namespace eha::cli
