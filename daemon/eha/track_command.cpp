// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "config/controller_config.hpp"
#include "config/file_kind.hpp"
#include "config/track_text.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/acquisition/run_report.hpp"
#include "daemon/eha/axis_table.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/controller_argument.hpp"
#include "daemon/eha/drive_options.hpp"
#include "daemon/eha/following_trip.hpp"
#include "daemon/eha/following_warning.hpp"
#include "daemon/eha/length_argument.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/eha/run_command.hpp"
#include "daemon/eha/track_report.hpp"
#include "daemon/identify/trip_cause.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/number_table.hpp"
#include "daemon/record/record_csv.hpp"
#include "daemon/record/resolved_path.hpp"
#include "daemon/record/run_header.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/report.hpp"
#include "daemon/track/track_result.hpp"

namespace eha::cli {
namespace {

constexpr const char* kTableFile = "axis_table.csv";

constexpr const char* kTrackFooter = R"(
Plays the trial of a controller (a file of `eha tune`) in closed loop: a step, trapezoids as fast as the reference may move,
a sweep that measures the margins, a sine and a hold of 60 s. It is a run like any other: every limit of the rig file
holds, a real actuator is moved only after your confirmation, Ctrl-C ramps out, and the way is recorded. Nothing of the
controller stays in force after it. It is a fault when the rod follows worse (following_error) or the command swings more
often (oscillation) than the controller's file allows. Prints what was measured beside what was promised, and writes
track.json, track.csv (the rows), axis_table.csv (model, valve, controller, promise and what was measured, for a
spreadsheet) and report.html into the run folder.
A controller for another rig, travel or valve is refused; on a machine [following] must be known. A simulated rig takes
the controller's tick with --local.
With a CSV file its set points are followed, joined by lines: columns time_s, from 0 s, and position_mm or position_in. The
rod is moved to the first one before. The reference generator keeps to the controller's limits of velocity and acceleration.
With RUN, the figures of an earlier run are computed again; nothing moves. Exit code 3: the promise is not kept.

Examples:
  eha track axis.toml --local --fast
  eha track axis.toml cycle.csv --local --fast
  eha track runs/20260101T120000Z-track-axis
  eha plot runs/20260101T120000Z-track-axis -o track.png)";

struct TrackCommand : DriveOptions {
  std::string source;                         ///< controller file or run folder
  std::string unit = {};                      ///< of a length that was typed; empty: none was
  std::optional<std::string> reference = {};  ///< CSV of set points
  config::TrackedMotion motion = {};
};

/// Refuses set points that cannot be followed, by row and in the unit of their file.
/// @param factor  inches of one of the file's units
void require_followable(const std::string& file, const ident::TrialPlan& plan, double factor, const std::string& unit) {
  const std::optional<ident::BadSetPoint> bad = ident::bad_set_point(plan);
  if (!bad) return;
  const ident::SetPoint& point = plan.reference[bad->index];
  const std::string row = fmt::format("{}: row {}", file, bad->index + 1);
  switch (bad->fault) {
    case ident::SetPointFault::first_not_at_zero:
      throw DataError(fmt::format("{}: the first set point is at {:g} s; let time_s begin at 0", row, point.time_s));
    case ident::SetPointFault::not_later:
      throw DataError(fmt::format("{}: {:g} s comes after {:g} s; let time_s rise from row to row", row, point.time_s,
                                  plan.reference[bad->index - 1].time_s));
    case ident::SetPointFault::outside_travel:
      throw DataError(
          fmt::format("{}: {:.5g} {} at {:g} s lies outside of the controller's travel, {:.5g} to {:.5g} {}", row,
                      point.position / factor, unit, point.time_s, plan.lowest / factor, plan.highest / factor, unit));
  }
}

/// Writes set points of a CSV file as tables of [track], and the first one as the start position.
std::string reference_text(const std::string& file, const ident::AxisSettings& settings) {
  const record::NumberTable table = record::read_number_table(file);
  const DisplayUnit inches("in");
  const ident::Channel position =
      table.names.size() == 2 ? record::channel_from_header(table.names[1]) : ident::Channel{};
  if (table.names.size() != 2 || table.names.front() != "time_s" || inches.of(position.unit) != "in") {
    throw DataError(
        fmt::format("{}: expected the columns time_s and a position such as position_mm or position_in, got {}", file,
                    fmt::join(table.names, ", ")));
  }
  const double factor = inches.factor(position.unit);
  ident::TrialPlan plan = ident::trial_plan(settings);
  std::string text;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const ident::SetPoint point{table.columns[0][i], factor * table.columns[1][i]};
    plan.reference.push_back(point);
    text += fmt::format("[[track.reference]]\ntime_s = {:#}\ndisplacement_in = {:#}\n", point.time_s, point.position);
  }
  require_followable(file, plan, factor, position.unit);
  return text + fmt::format("[start]\ndisplacement_in = {:#}\n", factor * table.columns[1].front());
}

}  // namespace

tune::TrialTrace trace_of(const track::TrackResult& result) {
  // Near the ends the means have fewer rows and more noise.
  const std::vector<double>& time_s = result.rows.time_s;
  const double reach_s = 0.5 * track::kMean_s;
  const auto first = std::lower_bound(time_s.begin(), time_s.end(), time_s.front() + reach_s) - time_s.begin();
  const auto last =
      std::max(first, std::upper_bound(time_s.begin(), time_s.end(), time_s.back() - reach_s) - time_s.begin());
  const auto inner = [&](const std::vector<double>& values) {
    return std::vector<double>(values.begin() + first, values.begin() + last);
  };
  return {.time_s = inner(time_s),
          .reference_in = inner(result.mean_reference_in),
          .rod_in = inner(result.mean_rod_in),
          .command_V = inner(result.rows.command_V),
          .sweep_s = result.sweep_s,
          .mean_s = track::kMean_s};
}

identify::FitTable table_of(const track::TrackResult& result) {
  return {.input = {"command", "V"},
          .output = {"displacement", "in"},
          .time_s = result.rows.time_s,
          .applied = result.rows.command_V,
          .measured = result.rows.rod_in,
          .models = {{"reference", result.rows.reference_in}}};
}

report::Page track_page(const track::TrackResult& result, const DisplayUnit& unit, const std::string& title,
                        const std::string& lead_html) {
  tune::ControllerSubject subject = controller_subject(result.controller);
  subject.title = title;
  // Timing, ticks and state of the rig, as the report of any other run has them.
  report::Subject run{.name = result.folder.filename().string()};
  run.manifest = record::to_json(record::read_manifest(result.opened.files()));
  const auto& started = run.part("utc_start");
  if (started.is_string()) subject.dated = ", tried " + report::utc_text(started.get<std::string>());
  for (report::Section section : {report::timing_section(run), report::manifest_section(run)}) {
    section.folded = true;
    subject.further.push_back(std::move(section));
  }
  subject.lead_html = lead_html;
  subject.rig = suggest::access_of_run(*run.manifest);
  if (lead_html.empty()) {
    subject.lead_html = report::paragraph(fmt::format("{}.", track::kept_text(result)));
  }
  tune::MeasuredTrial& trial = subject.measured.emplace();
  trial.run = result.folder.filename().string();
  for (const track::KeptFigure& f : result.figures) {
    trial.figures.push_back({f.name, f.measured, f.unit, track::kept_text(f), f.noise, f.limit(),
                             f.bound == track::Bound::least, f.is_lower_bound});
  }
  trial.by_sweep = fmt::format("{}", fmt::join(track::sweep_sentences(result, unit), " "));
  trial.changes = track::changes_of(result, unit);
  trial.advice = track::advice_of(result, unit);
  trial.leaks = result.leak.has_value();
  subject.unit = unit;
  trial.trace = trace_of(result);
  return tune::controller_page(subject);
}

bool shows_its_cause(const std::filesystem::path& folder) {
  try {
    const record::OpenRun run(folder);
    if (record::purpose_of(record::read_manifest(run.files())) == record::Purpose::tracking) {
      return track::ended_trial(run, DisplayUnit("in")).is_cause_known();
    }
    return identify::trip_cause(record::read_run(run)).has_value();
  } catch (const Error&) {  // nothing was recorded
    return false;
  }
}

void explain_ended_trial(const std::filesystem::path& folder, const std::string& rig_units, TrackFiles files,
                         const Console& console, const std::optional<std::string>& remedy) {
  try {
    const record::OpenRun run(folder);
    const record::Manifest manifest = record::read_manifest(run.files());
    const bool is_broken = manifest.outcome == acquisition::Outcome::faulted;
    const DisplayUnit unit = console.unit(rig_units);
    const track::EndedTrial trial = track::ended_trial(run, unit);
    const std::string advice = track::advice_of(trial, unit);
    if (is_broken) {
      for (const std::string& change : trial.changes) console.info("until then the moving rod shows: " + change);
      if (!trial.stood.empty()) console.info(trial.stood);
      console.info(advice.empty() ? "the promise is not kept" : "the promise is not kept. " + advice);
    } else {
      console.info("the trial was stopped: the promise is not judged");
    }
    if (files == TrackFiles::write) {
      track::write_ended_track(run);
      for (const std::string& missing : report::write_into_run(run, unit)) console.warning(missing);
    }
    const std::string page = report_of_run(folder, "eha plot " + shell_word(folder.string()));
    const bool is_of_valve = may_be_of_following(trip_of(manifest));
    if (!is_broken) {
      console.next_step(page);
      if (!console.rig().controller.empty()) {
        console.next_step(suggest::track(console.rig(), console.rig().controller));
      }
    } else if (trial.is_of_sensor) {
      console.next_step(suggest::read(console.rig()));
    } else if (!trial.cause.empty() || trial.played.leak) {
      console.next_step(page);
    } else if (remedy) {
      console.next_step(*remedy);
    } else {
      console.next_step(is_of_valve && console.rig().is_fast ? suggest::characterise(console.rig()) : page);
    }
  } catch (const Error& error) {  // nothing was recorded
    console.debug(error.what());
  }
}

ExitCode show_track(const record::OpenRun& run, TrackFiles wanted, const Console& console) {
  const track::TrackResult result = track::track_result(run);
  const DisplayUnit unit = console.unit(result.units);
  if (wanted == TrackFiles::write) {
    track::write_track(result);
    os::write_file_atomically(run.files() / kTableFile, axis_table({.controller = result.controller,
                                                                    .model = model_of(result.controller),
                                                                    .sheet = sheet_of(result.controller),
                                                                    .measured = result.figures},
                                                                   unit));
    const report::Page page = track_page(result, unit);
    os::write_file_atomically(run.files() / report::kReportFile, page.html);
    for (const std::string& sentence : page.missing) console.warning(sentence);
  }
  warn_of_unused_sheet(result.folder, console);
  const ExitCode code = result.is_kept() ? ExitCode::ok : ExitCode::model_rejected;
  nlohmann::ordered_json document = track::to_json(result);
  document["exit_code"] = static_cast<int>(code);
  console.print_json(document);
  console.print(track::track_text(result, unit));
  if (wanted == TrackFiles::write) {
    console.print("As a table, with model and valve: " + (result.folder / kTableFile).string());
  }
  const std::string& model = result.controller.provenance.model;
  std::error_code ignored;
  if (std::filesystem::is_regular_file(model, ignored)) {
    console.print("The plant for MATLAB: eha export " + shell_word(model) + " --format tf");
    console.print("Its Bode plot: eha plot " + shell_word(model) + " -o " + shell_word(free_name("bode.svg")));
  }
  if (!track::goes_to_plc(result, unit)) {
    console.print(
        result.leak ? fmt::format("No controller of a rig that leaks goes to a PLC: {}.", ident::kRepairFirst)
        : result.is_kept()
            ? std::string(
                  "The controller goes to no PLC on this trial alone, by which the valve may not be the one that it "
                  "was made for: the whole trial, `eha track` without a reference, decides.")
            : std::string("The controller goes to no PLC yet: its promise was not kept."));
  } else if (const std::string& controller = console.rig().controller; !controller.empty()) {
    console.print(
        fmt::format("The controller for a PLC, C, MATLAB: {} (or c, simulink)", suggest::export_for_plc(controller)));
  }
  console.next_step(report_of_run(result.folder, "eha report " + shell_word(result.folder.string())));
  console.next_step("eha plot " + shell_word(result.folder.string()) + " -o " + shell_word(free_name("track.png")));
  return code;
}

namespace {

/// A length above 0 with its unit, in inches. @throws CLI::ValidationError
double typed_length(const std::string& option, const std::string& text) {
  const std::optional<double> length_in = inches_of(text);
  if (length_in && *length_in > 0.0) return *length_in;
  if (inches_of(text + "in")) {
    throw CLI::ValidationError(option, fmt::format("a length needs its unit; write {0}mm or {0}in", text));
  }
  throw CLI::ValidationError(
      option, fmt::format("\"{}\": expected a length above 0 with its unit, such as 20mm or 0.8in", text));
}

/// Refuses a step and a sine for which the controller has no travel, in the unit that the user has typed.
void require_room(const TrackCommand& command, const ident::AxisSettings& settings, const Console& console) {
  if (!command.motion.step_in && !command.motion.sine_in) return;
  const ident::TrialPlan plan = ident::trial_plan(settings);
  const double half_in = 0.5 * (settings.reference.highest - settings.reference.lowest);
  const double step_in = command.motion.step_in.value_or(plan.step);
  const double sine_in = command.motion.sine_in.value_or(plan.sine);
  if (step_in + sine_in <= half_in) return;
  const DisplayUnit unit = console.unit();
  const double factor = unit.factor("in");
  throw UsageError(
      fmt::format("--step {0:.4g}{3} and the sine's amplitude of {1:.3g} {3}: together at most half of the "
                  "controller's travel, {2:.4g} {3}",
                  factor * step_in, factor * sine_in, factor * half_in, unit.of("in")));
}

}  // namespace

ExitCode execute(const TrackCommand& command, Console& console) {
  std::error_code ignored;
  if (std::filesystem::is_directory(command.source, ignored)) {
    const record::Manifest manifest = record::read_manifest(command.source);
    console.set_rig(access_of_run(command.source));
    if (record::purpose_of(manifest) == record::Purpose::tracking &&
        (manifest.outcome == acquisition::Outcome::faulted || manifest.outcome == acquisition::Outcome::interrupted)) {
      const std::string end = manifest.report ? manifest.report->description : "";
      console.info(
          fmt::format("{}: {}", command.source, shows_its_cause(command.source) ? record::without_remedy(end) : end));
      explain_ended_trial(command.source, record::rig_units(manifest.other), TrackFiles::keep, console);
      return manifest.outcome == acquisition::Outcome::faulted ? ExitCode::model_rejected : ExitCode::interrupted;
    }
    return show_track(record::OpenRun(command.source), TrackFiles::keep, console);
  }
  RunCommand run{command};
  run.experiment_file = "track " + command.source;
  run.controller_file = command.source;
  const std::string text = config::read_config_file(command.source);
  const config::ControllerConfig controller = config::parse_controller(text, command.source);
  if (std::filesystem::is_regular_file(controller.provenance.model, ignored)) {
    run.controller_model = controller.provenance.model;
  }
  if (!command.unit.empty()) console.take_typed_unit(command.unit);
  require_room(command, controller.settings, console);
  run.text =
      config::track_experiment(controller.name, text, command.motion, record::resolved_path(command.source).string());
  if (command.reference) *run.text += reference_text(*command.reference, controller.settings);
  run.simulated_tick_s = controller.settings.tick_s;
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
  sub->add_option("reference", track.reference,
                  "Set points to follow instead of the trial (CSV: time_s and position_mm or _in)")
      ->type_name("CSV");
  const auto add_length = [&](const char* name, std::optional<double>& target_in, const char* help) {
    sub->add_option_function<std::string>(
           name,
           [name, &target_in, &track](const std::string& text) {
             target_in = typed_length(name, text);
             track.unit = unit_of_length(text);
           },
           help)
        ->type_name("LENGTH");
  };
  add_length("--step", track.motion.step_in, "Way of the step and the trapezoids, such as 20mm or 0.8in");
  add_length("--sine", track.motion.sine_in, "Amplitude of the sine, such as 2mm or 0.08in");
  sub->add_option("--frequency", track.motion.sine_Hz, "Frequency of the sine [Hz]")
      ->type_name("HZ")
      ->check(positive());
  sub->add_option("--hold", track.motion.hold_s, "Duration of the hold (default 60 s, which the promise is for)")
      ->type_name("SECONDS")
      ->check(positive());
  sub->add_flag_callback(
      "--no-sweep", [&track] { track.motion.sweep = false; }, "Leave out the sweep, which measures the margins");
  add_drive_options(*sub, track);
}

}  // namespace eha::cli
