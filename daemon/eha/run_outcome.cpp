// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/run_outcome.hpp"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "core/display_unit.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/following_trip.hpp"
#include "daemon/eha/following_warning.hpp"
#include "daemon/eha/identification_report.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/place_text.hpp"
#include "daemon/eha/rehearsal_text.hpp"
#include "daemon/eha/run_command.hpp"
#include "daemon/eha/sheet_answer.hpp"
#include "daemon/eha/track_report.hpp"
#include "daemon/identify/identification.hpp"
#include "daemon/identify/publish.hpp"
#include "daemon/identify/source.hpp"
#include "daemon/play/play.hpp"
#include "daemon/record/run_folder.hpp"
#include "hal/backends/backend.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;

/// Reports a run that did not complete or lost its guard: the cause, and the kept record.
ExitCode report_incomplete(const Acquired& acquired, const config::ExperimentConfig& experiment,
                           const config::RigConfig& rig, Console& console) {
  const DisplayUnit unit = console.unit(rig.units);
  const bool characterises = experiment.characterises();
  const play::FinishedRun& run = acquired.run;
  if (!acquisition::is_whole(run.report.outcome)) {
    std::string end = acquisition::describe(run.report, unit);
    if (characterises && !rig.limits.following) end = without_causes_of_following(std::move(end));
    console.error(shows_its_cause(run.folder) ? record::without_remedy(end) : end);
  }
  if (!run.write_error.empty()) console.error(run.write_error);
  const std::string folder = run.folder.string();
  if (characterises) {
    const Trip trip = trip_of(run.report.fault);
    const WayOut way_out = rig.limits.following ? WayOut{way_out_of_following(trip, rig.file_name, console.rig()), {}}
                                                : way_out_without_following(trip, rig.file_name);
    if (!way_out.sentence.empty()) console.info(way_out.sentence);
    if (!way_out.lines.empty()) console.print(way_out.lines);
  }
  const bool has_other_valve = experiment.played() != nullptr && explain_trip(folder, console);
  std::error_code unknown;
  bool has_page = false;
  if (!fs::exists(run.folder / record::kJournalFile, unknown)) {
    console.info(fmt::format("{} holds no record of this run", folder));
  } else if (!fs::exists(run.folder / record::kRawFile, unknown)) {
    console.info(fmt::format("the partial record is in {}; once there is room, `eha runs recover {}` completes it",
                             folder, shell_word(folder)));
  } else if (experiment.tracking() != nullptr) {
    console.info(kept_record_text(run.folder));
  } else if (run.only_placed || characterises) {
    console.info(kept_record_text(run.folder));
  } else {
    console.info(partial_record_text(run.folder));
    std::vector<fs::path> written;
    write_report(record::OpenRun(run.folder), unit, written, console);
    has_page = !written.empty();
  }
  const bool is_guards_fault = !acquired.was_guarded && (acquisition::is_whole(run.report.outcome) ||
                                                         run.report.outcome == acquisition::Outcome::interrupted);
  const ExitCode code = is_guards_fault ? ExitCode::device_unavailable : acquisition::exit_code(run.report);
  console.print_json({{"schema", "eha-run/1"},
                      {"run", run.folder.string()},
                      {"outcome", acquisition::to_text(run.report.outcome)},
                      {"exit_code", static_cast<int>(code)}});
  const auto remedy = code == ExitCode::safety_trip ? warn_of_unused_sheet(run.folder, console) : std::nullopt;
  if (experiment.tracking() != nullptr) {
    explain_ended_trial(run.folder, rig.units, TrackFiles::write, console, remedy);
  } else if (remedy) {
    console.next_step(*remedy);
  } else if ((run.only_placed || characterises) && code == ExitCode::safety_trip) {
    console.next_step(next_after_trip(trip_of(run.report.fault), &rig, console.rig()));
  } else if (characterises && code == ExitCode::deadline) {
    console.next_step("eha doctor");
  } else if (has_page) {
    if (has_other_valve) console.next_step(suggest::characterise(console.rig()));
    console.next_step(report_of_run(run.folder, "eha report " + shell_word(folder)));
    // After a trip the report says what to correct before a fit is of use.
    const auto fit = code == ExitCode::safety_trip ? std::nullopt : fit_of_run(run.folder);
    if (fit) console.next_step(*fit);
  }
  return code;
}

/// Reports a rod that has reached its place.
ExitCode report_placed(const play::FinishedRun& run, double place_in, const std::string& units, const std::string& next,
                       const Console& console) {
  warn_of_unused_sheet(run.folder, console);
  print_place(run.displacement_in, units, next, console);
  console.print_json({{"schema", "eha-run/1"},
                      {"run", run.folder.string()},
                      {"outcome", acquisition::to_text(run.report.outcome)},
                      {"place_in", place_in},
                      {"displacement_in", run.displacement_in},
                      {"exit_code", 0}});
  return ExitCode::ok;
}

ExitCode identify_run(const fs::path& folder, Console& console) {
  const identify::Source source = identify::load_source(folder.string(), std::nullopt);
  const identify::IdentificationTask task = identify::task_of(source);
  for (const std::string& remark : source.remarks) console.warning(remark);
  print_warnings(source, task.options.decimation, console);
  using Paper = identify::Comparisons::Paper;
  const Paper paper = source.experiment && source.experiment->compares_with_paper ? Paper::include : Paper::leave_out;
  const identify::Identification identification = identify::identify(
      source, task, {.paper = paper, .ladder = identify::Comparisons::Ladder::include}, console.progress_callback());
  console.end_progress();
  std::vector<fs::path> written = identify::publish(identification, source.opened);
  const DisplayUnit unit = console.unit(source.units);
  console.set_rig(suggest::with_fit_of(console.rig(), folder.string()));
  write_report(source.opened, unit, written, console);
  print_identification(
      identification, written,
      {{"schema", "eha-run/1"}, {"run", folder.string()}, {"outcome", acquisition::to_text(source.outcome)}}, unit,
      console);
  const ValveNow valve = warn_of_changed_valve(folder, console);
  const ident::NextStep first = identify::next_step_of(identification);
  const auto cut = first.cut_options.empty() ? std::nullopt : cut_of_run(folder);
  if (cut) console.next_step(*cut);
  if (first.first == ident::FirstStep::look_at_sensor) console.next_step(suggest::read(console.rig()));
  const auto next = identify::next_experiment_file(written);
  console.next_step(next ? suggest::run(console.rig(), {next->string()})
                         : report_of_run(folder, "eha runs show " + shell_word(folder.string())));
  if (valve == ValveNow::changed && !next) {
    console.next_step(suggest::characterise(console.rig()));
  } else if (const auto tune = tune_of_run(folder, console.rig());
             tune && !next && valve == ValveNow::as_known && first.first == ident::FirstStep::none) {
    console.next_step(*tune);
  }
  return identify::exit_code(identification.models);
}

// The outcome of each kind.

ExitCode outcome_of(const config::Played&, const play::FinishedRun& run, const RunCommand&, const config::RigConfig&,
                    Console& console) {
  return identify_run(run.folder, console);
}

ExitCode outcome_of(const config::Placing& placing, const play::FinishedRun& run, const RunCommand&,
                    const config::RigConfig& rig, Console& console) {
  std::string next = suggest::read(console.rig());
  if (begins_anew(rig, Player::local)) {
    next = "eha plot " + shell_word(run.folder.string());
    console.info(
        fmt::format("a simulated rig of --local begins each time where {} says: the next command finds the rod there, "
                    "not here",
                    rig.file_name));
  }
  return report_placed(run, placing.place.displacement_in, rig.units, next, console);
}

ExitCode outcome_of(const config::SheetRun&, const play::FinishedRun& run, const RunCommand& command,
                    const config::RigConfig&, Console& console) {
  std::optional<NewRigFile> rig_file;
  if (command.new_rig_file) rig_file = NewRigFile{*command.new_rig_file};
  return show_valve_sheet(record::OpenRun(run.folder), SheetFiles::write, rig_file, console);
}

ExitCode outcome_of(const config::Tracking&, const play::FinishedRun& run, const RunCommand&, const config::RigConfig&,
                    Console& console) {
  return show_track(record::OpenRun(run.folder), TrackFiles::write, console);
}

/// Returns the command that later computes the run's results.
std::string later_command(const config::ExperimentConfig& experiment, const fs::path& folder) {
  const std::string_view command = std::visit([](const auto& kind) { return kind.kCommand; }, experiment.kind);
  return fmt::format("`eha {} {}` does it", command, shell_word(folder.string()));
}

}  // namespace

ExitCode conclude(const RunCommand& command, const config::RigConfig& rig, const config::ExperimentConfig& experiment,
                  const Acquired& acquired, Console& console) {
  const play::FinishedRun& run = acquired.run;
  if (!acquisition::is_whole(run.report.outcome) || !acquired.was_guarded) {
    return report_incomplete(acquired, experiment, rig, console);
  }
  if (acquired.was_stopped && !run.only_placed) {
    console.info(fmt::format("stopped after the motion: the record is whole, and nothing is computed from it; {}",
                             later_command(experiment, run.folder)));
    console.print_json({{"schema", "eha-run/1"},
                        {"run", run.folder.string()},
                        {"outcome", acquisition::to_text(run.report.outcome)},
                        {"exit_code", static_cast<int>(ExitCode::interrupted)}});
    return ExitCode::interrupted;
  }
  return std::visit([&](const auto& kind) { return outcome_of(kind, run, command, rig, console); }, experiment.kind);
}

}  // namespace eha::cli
