// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/run_command.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "config/characterisation.hpp"
#include "config/prepared_experiment.hpp"
#include "config/tone_grid.hpp"
#include "core/display_unit.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/commands.hpp"
#include "daemon/eha/following_trip.hpp"
#include "daemon/eha/following_warning.hpp"
#include "daemon/eha/identification_report.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/place_text.hpp"
#include "daemon/eha/rehearsal_text.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/ruler.hpp"
#include "daemon/eha/run_line.hpp"
#include "daemon/eha/run_service.hpp"
#include "daemon/eha/sleep_delay.hpp"
#include "daemon/eha/stop_on_signals.hpp"
#include "daemon/eha/track_report.hpp"
#include "daemon/eha/valve_sheet.hpp"
#include "daemon/identify/identification.hpp"
#include "daemon/identify/publish.hpp"
#include "daemon/identify/source.hpp"
#include "daemon/play/play.hpp"
#include "daemon/precision/precision_watch.hpp"
#include "daemon/record/recover.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/rig/arming.hpp"
#include "daemon/rig/calibration.hpp"
#include "daemon/rig/confirmation.hpp"
#include "daemon/rig/motion_at_rest.hpp"
#include "daemon/rig/narrower_limits.hpp"
#include "daemon/rig/owned_rig.hpp"
#include "daemon/rig/rod_view.hpp"
#include "daemon/rig/trusted_file.hpp"
#include "hal/backends/backend.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRunFooter = R"(
Plays the experiment's excitation [V] on the rig every tick, records the displacement, fits the experiment's
models and judges them. The run folder OUTPUT/<UTC time>-<name> holds run.json, raw.ehalog, raw.h5, data_40ms.csv,
frequency_response.csv, fit.csv, report.html and models/*.json; a rejected model goes to models/rejected. OUTPUT/latest
points to the last run with an accepted model.
One Ctrl-C ramps the command down and keeps the record; a second one makes the rig safe at once.
Without --local the service ehad does the same with its own rig file and folder, when the experiment is next in its
queue and you hold the lease (`eha arm`). Ctrl-C stops the run; losing the connection does not.
All experiments are checked before the first one is queued or played; a fault in one refuses all.
During a run a terminal shows the time left [s], the rod between its limits, the command [V], late ticks and the predicted
margin to the travel limits; elsewhere a line appears every 30 s.

Examples:
  eha arm && eha run config/experiments/paper.toml
  eha run slow.toml fast.toml --detach
  eha run config/experiments/paper.toml --local --fast
  eha run sweep.toml --local --rig rig.toml --output /data/runs)";

/// A checked experiment of the command line.
struct PlannedRun {
  std::string file;
  config::PreparedExperiment experiment;
  std::optional<double> margin_in = {};  ///< predicted distance to the nearer travel limit [in]
};

/// What the runs of one command leave for the next one.
struct EarlierRuns {
  acquisition::MissingMotion missing = {};
  std::optional<play::FinishedRun> last = {};
};

/// The hydraulics were off since the run before, and nobody read the rod. @throws DeviceError
void require_rod_at_rest(const EarlierRuns& earlier, double place_in, const DisplayUnit& unit) {
  if (!earlier.last) return;
  const double moved_in = place_in - earlier.last->displacement_in;
  if (!(std::abs(moved_in) >
        most_motion_at_rest(std::chrono::steady_clock::now() - earlier.last->ended, earlier.last->velocity_in_per_s)))
    return;
  throw DeviceError(
      fmt::format("the rod's reading has moved by {:.2g} {} since the run before, while nothing drove it: look at the "
                  "rod, its contactor and its sensor before the next run",
                  unit.factor("in") * moved_in, unit.of("in")));
}

struct Acquired {
  play::FinishedRun run;
  bool was_guarded = true;   ///< the guard lived to the end
  bool was_stopped = false;  ///< by a signal, which may have come after the last tick
};

TravelRisk risk_of(const RunCommand& command) {
  return command.accept_travel_risk ? TravelRisk::accept : TravelRisk::refuse;
}

/// Rehearses an experiment from a place of the rod, and reports it. @returns the predicted margin [in]
/// @throws ConfigError  it reaches a limit
std::optional<double> rehearsed_margin(const PlannedRun& planned, const config::RigConfig& rig, double place_in,
                                       TravelRisk risk, Console& console) {
  require_within_travel(planned.experiment.config, rig, place_in, planned.file, console, Player::local);
  const std::optional<Rehearsal> rehearsal = rehearse(planned.experiment, rig, place_in);
  report_rehearsal({planned.experiment, rig, place_in, rehearsal, Player::local}, planned.file, risk, console);
  return margin_of(rehearsal, rig);
}

/// Plays and records an experiment. The rig is idle or safe on return and after an exception.
/// @param earlier  the runs before, then this one, too
/// @param stop     lives since before the rig is opened and until after it is closed: a signal must not end the process
Acquired acquire(const RunCommand& command, const config::RigConfig& rig_config, const PlannedRun& planned,
                 EarlierRuns& earlier, StopOnSignals& stop, Console& console) {
  const config::PreparedExperiment& experiment = planned.experiment;
  // The question before, or the fit of the run before, may have taken hours.
  if (hal::moves_machine(rig_config.backend)) {
    require_no_narrower_limits(rig_config, rig_config.file_name, "give the command again");
  }
  OwnedRig local(rig_config);
  if (hal::moves_machine(rig_config.backend)) require_plausible_inputs(local.rig(), rig_config);
  if (local.is_unguarded())
    throw DeviceError("the guard of the rig (eha-safe --guard) does not run; nothing is driven");
  std::optional<double> margin_in = planned.margin_in;
  std::optional<RodAtRest> rest;  // of a machine
  if (!begins_anew(rig_config, Player::local)) {
    const double place_in = place_of(local.rig());
    rest = RodAtRest{.at = std::chrono::steady_clock::now(), .place_in = place_in};
    require_rod_at_rest(earlier, place_in, console.unit(rig_config.units));
    require_place_to_begin(experiment.config, place_in, planned.file, console.unit(rig_config.units));
    if (std::abs(place_in - start_of(rig_config)) > kSamePlace_in) {
      margin_in = rehearsed_margin(planned, rig_config, place_in, risk_of(command), console);
    }
  }
  acquisition::StateMachine machine;
  machine.reset();
  machine.arm();
  const fs::path folder = record::create_run_folder(command.output, experiment.config.name);
  const auto early_end =
      precision::watch_of(experiment.config, rig_config, folder, [&console](const std::string& sentence) {
        console.end_progress();
        console.info(sentence);
      });
  const play::PlayRequest request{
      .rig = rig_config,
      .experiment = experiment.config,
      .table_V = {experiment.table_V.data(), static_cast<std::size_t>(experiment.table_V.size())},
      .predicted_in = {experiment.predicted_in.data(), static_cast<std::size_t>(experiment.predicted_in.size())},
      .folder = folder,
      .time_base = command.fast ? acquisition::TimeBase::virtual_time : acquisition::TimeBase::monotonic,
      .non_realtime = command.allow_non_realtime ? acquisition::NonRealtime::allow : acquisition::NonRealtime::refuse,
      .early_end = early_end.get(),
      .missing = &earlier.missing,
      .page = &local.page(),
      .share_journal = [&local](const os::FileDescriptor& journal) { local.hold(journal); },
      .before_driven =
          [&](hal::Rig& rig) {
            if (rest) require_at_rest(rig, *rest, console.unit(rig_config.units));
          }};
  const DisplayUnit unit = console.unit(rig_config.units);
  SleepDelay sleep(hal::moves_machine(rig_config.backend) ? Suspends::are_delayed : Suspends::do_not_matter,
                   stop.request());
  const auto tell_of_sleep = [&] {
    const std::string news = sleep.news();
    if (news.empty()) return;
    console.end_progress();
    console.warning(news);
  };
  bool was_guarded = true;
  const auto miss_guard = [&](const char* consequence) {
    if (!was_guarded) return;
    was_guarded = false;
    console.end_progress();
    console.error(fmt::format("the guard of the rig (eha-safe --guard) has died{}", consequence));
  };
  play::FinishedRun run =
      play::play(local.rig(), machine, request, stop.request(), [&](const acquisition::Snapshot& now) {
        if (was_guarded && local.is_unguarded()) {
          stop.request().request_ramp_out();
          miss_guard("; nothing is driven without it: ramping out");
        }
        stop.notice_lost_terminal();
        tell_of_sleep();
        RunProgress progress = progress_of(now, rig_config);
        progress.is_real_time = !command.fast;
        progress.is_placing = experiment.config.placing() != nullptr;
        progress.margin_in = margin_in;
        const bool explores = experiment.config.characterises() && !rig_config.limits.following;
        if (explores && progress.played_s <= 0.0) progress.exploring_at_most_s = config::kLongestExploring_s;
        console.show_run(run_line(progress, unit, std::chrono::system_clock::now()));
      });
  console.end_progress();
  tell_of_sleep();
  try {
    if (run.report.safe_confirmed) local.made_safe();
  } catch (const DeviceError&) {
    miss_guard(" before the end");
  }
  for (const std::string& sentence : run.report.realtime.refused) console.warning(sentence);
  using acquisition::RunKind;
  for (const std::string& sentence :
       acquisition::warnings(run.report, run.only_placed ? RunKind::placing : RunKind::experiment)) {
    console.warning(sentence);
  }
  for (const delays::Delay& delay : run.delays) console.warning(delays::sentence_of(delay));
  return {std::move(run), was_guarded};
}

/// The same, with a stop that comes as late as while the rig is closed.
Acquired acquire(const RunCommand& command, const config::RigConfig& rig_config, const PlannedRun& planned,
                 EarlierRuns& earlier, Console& console) {
  StopOnSignals stop;
  Acquired acquired = acquire(command, rig_config, planned, earlier, stop, console);
  earlier.last = acquired.run;
  acquired.was_stopped = stop.end() > 0;
  return acquired;
}

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
    const std::string end = acquisition::describe(run.report, unit);
    const WayOut way_out = rig.limits.following ? WayOut{way_out_of_following(end, rig.file_name, console.rig()), {}}
                                                : way_out_without_following(end, rig.file_name);
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
  } else if (run.only_placed && code == ExitCode::safety_trip) {
    console.next_step(
        next_after_trip(acquisition::describe(run.report, unit), hal::moves_machine(rig.backend), console.rig()));
  } else if (characterises && code == ExitCode::safety_trip) {
    console.next_step(suggest::read(console.rig()));
  } else if (characterises && code == ExitCode::deadline) {
    console.next_step("eha doctor");
  } else if (has_page) {
    if (has_other_valve) console.next_step(suggest::characterise(console.rig()));
    console.next_step(report_of_run(run.folder, "eha report " + shell_word(folder)));
    if (const auto fit = fit_of_run(run.folder)) console.next_step(*fit);
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

ExitCode conclude(const config::Played&, const play::FinishedRun& run, const RunCommand&, const config::RigConfig&,
                  Console& console) {
  return identify_run(run.folder, console);
}

ExitCode conclude(const config::Placing& placing, const play::FinishedRun& run, const RunCommand&,
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

ExitCode conclude(const config::SheetRun&, const play::FinishedRun& run, const RunCommand& command,
                  const config::RigConfig&, Console& console) {
  std::optional<NewRigFile> rig_file;
  if (command.new_rig_file) rig_file = NewRigFile{*command.new_rig_file};
  return show_valve_sheet(record::OpenRun(run.folder), SheetFiles::write, rig_file, console);
}

ExitCode conclude(const config::Tracking&, const play::FinishedRun& run, const RunCommand&, const config::RigConfig&,
                  Console& console) {
  return show_track(record::OpenRun(run.folder), TrackFiles::write, console);
}

/// Completes runs whose process died. Leaves a run alone that another process is still writing.
void recover_earlier_runs(const fs::path& folder, const Console& console) {
  const auto warn = [&console](const std::string& message) { console.warning(message); };
  record::recover_torn_runs(folder, {.recovered = warn, .failed = warn});
}

/// Reads, checks and rehearses an experiment of the command line. @param text  none: the file is read
PlannedRun plan(const std::string& file, const std::optional<std::string>& text, const config::RigConfig& rig,
                TravelRisk risk, Console& console) {
  PlannedRun planned{.file = file,
                     .experiment = text ? config::parse_prepared_experiment(*text, file, rig)
                                        : config::load_prepared_experiment(file, rig)};
  const config::Placing* placing = planned.experiment.config.placing();
  if (!text && placing != nullptr && placing->brings_back) refuse_way_back(file);
  warn_if_not_fittable(planned.experiment.config, rig, file, console);
  warn_if_not_rehearsed(planned.experiment.config, rig, file, console);
  say_motion_shown_first(planned.experiment.config, rig, console);
  planned.margin_in = rehearsed_margin(planned, rig, start_of(rig), risk, console);
  return planned;
}

/// Returns the command that later computes the run's results.
std::string later_command(const config::ExperimentConfig& experiment, const fs::path& folder) {
  const std::string_view command = std::visit([](const auto& kind) { return kind.kCommand; }, experiment.kind);
  return fmt::format("`eha {} {}` does it", command, shell_word(folder.string()));
}

/// Plays one.
Acquired record_one(const RunCommand& command, const config::RigConfig& rig, const PlannedRun& planned,
                    EarlierRuns& earlier, Console& console) {
  const config::ExperimentConfig& experiment = planned.experiment.config;
  const std::string length = experiment.placing() != nullptr
                                 ? fmt::format("at most {:g} s", experiment.duration_s)
                                 : fmt::format("{:g} s, {} repetition{}", experiment.duration_s, experiment.repetitions,
                                               experiment.repetitions == 1 ? "" : "s");
  console.info(fmt::format("{}: {} on {} ({})", experiment.placing() != nullptr ? planned.file : experiment.name,
                           length, rig.name, rig.file_name));
  if (const auto sentence = config::off_grid_tones(experiment)) console.warning(*sentence);
  Acquired acquired = acquire(command, rig, planned, earlier, console);
  console.info(fmt::format("recorded in {}", acquired.run.folder.string()));
  if (const std::string_view circuit = acquisition::sentence_of(acquired.run.circuit); !circuit.empty()) {
    console.warning(std::string(circuit));
  }
  return acquired;
}

/// Whether the next one may follow.
bool is_sound(const Acquired& acquired) {
  return acquisition::is_whole(acquired.run.report.outcome) && acquired.was_guarded && !acquired.was_stopped &&
         acquired.run.circuit == acquisition::CircuitAtRest::sound;
}

/// Fits and judges one that was played.
ExitCode conclude_one(const RunCommand& command, const config::RigConfig& rig, const PlannedRun& planned,
                      const Acquired& acquired, Console& console) {
  const config::ExperimentConfig& experiment = planned.experiment.config;
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
  return std::visit([&](const auto& kind) { return conclude(kind, run, command, rig, console); }, experiment.kind);
}

}  // namespace

ExitCode execute(const RunCommand& command, Console& console) {
  console.set_rig(access_of(command));
  if (!command.local) return run_through_service(command, console);
  config::RigConfig rig = load_rig_or_default(command.rig_file);
  if (command.simulated_tick_s && !hal::moves_machine(rig.backend) &&
      *command.simulated_tick_s != rig.realtime.sample_period_s) {
    rig = config::parse_rig(rig_text_with_tick(rig, *command.simulated_tick_s), rig.file_name);
  }
  if (command.fast && !hal::has_virtual_clock(rig.backend)) {
    throw UsageError(fmt::format("--fast: {} drives a real machine, which runs in real time only", rig.file_name));
  }
  // Checks all of them before the first one is played.
  const TravelRisk risk = risk_of(command);
  const auto warn_of = [&](const std::string& file) {
    if (!command.further_files.empty()) console.set_subject(file);
  };
  const std::vector<PlannedRun> planned = as_a_list(command, "played", [&] {
    warn_of(command.experiment_file);
    std::vector<PlannedRun> list{plan(command.experiment_file, command.text, rig, risk, console)};
    for (const std::string& file : command.further_files) {
      warn_of(file);
      list.push_back(plan(file, std::nullopt, rig, risk, console));
    }
    console.set_subject("");
    require_local_rig_file(rig);
    require_protecting_limits(rig);
    return list;
  });
  for (const std::string& sentence : arming_findings(rig).warnings) console.warning(sentence);
  if (std::any_of(planned.begin(), planned.end(),
                  [](const PlannedRun& one) { return one.experiment.config.characterises(); })) {
    agreed_ruler(command, command.ruler, console);
  }
  std::string confirmation;
  for (const PlannedRun& one : planned) {
    if (const auto text = confirmation_text(rig, one.experiment.config)) {
      confirmation += (confirmation.empty() ? "" : "\n") + *text;
    }
  }
  if (!confirmation.empty() && !command.yes && !console.confirm(confirmation)) {
    console.info("not confirmed; nothing was moved");
    return ExitCode::interrupted;
  }
  recover_earlier_runs(command.output, console);
  EarlierRuns earlier;
  if (planned.size() == 1) {
    const Acquired acquired = record_one(command, rig, planned.front(), earlier, console);
    return conclude_one(command, rig, planned.front(), acquired, console);
  }
  console.keep_documents();
  ExitCode code = ExitCode::ok;
  std::vector<std::string> rest;
  // A machine is not left unwatched for the fit of a run before the next one is played.
  const std::size_t at_once = hal::moves_machine(rig.backend) ? planned.size() : 1;
  std::size_t begun = 0;
  bool was_stopped = false;
  for (bool goes_on = true; goes_on && begun < planned.size();) {
    std::vector<Acquired> acquired;
    std::exception_ptr refusal;
    for (; goes_on && begun < planned.size() && acquired.size() < at_once;
         goes_on = goes_on && is_sound(acquired.back())) {
      const PlannedRun& one = planned[begun];
      warn_of(one.file);
      try {
        acquired.push_back(record_one(command, rig, one, earlier, console));
        was_stopped = acquired.back().was_stopped;
        ++begun;
      } catch (const Error&) {
        if (acquired.empty()) throw;
        refusal = std::current_exception();
        break;
      }
    }
    for (std::size_t i = 0; i < acquired.size(); ++i) {
      const PlannedRun& one = planned[begun - acquired.size() + i];
      console.print(one.file + ":");
      warn_of(one.file);
      ExitCode own = ExitCode::ok;
      try {
        own = conclude_one(command, rig, one, acquired[i], console);
      } catch (const Error& error) {
        if (at_once == 1) throw;
        console.error(error.what());  // those after it were played, too
        own = error.exit_code();
      }
      if (code == ExitCode::ok) code = own;
    }
    if (refusal) std::rethrow_exception(refusal);
  }
  if (begun < planned.size() && code == ExitCode::ok) {
    code = was_stopped ? ExitCode::interrupted : ExitCode::safety_trip;  // by a line of the rig
  }
  for (std::size_t i = begun; i < planned.size(); ++i) rest.push_back(planned[i].file);
  const nlohmann::ordered_json documents = console.taken_documents();
  console.print_json({{"schema", "eha-run-list/1"}, {"runs", documents}, {"exit_code", static_cast<int>(code)}});
  if (!rest.empty()) {
    console.set_subject("");
    console.info(fmt::format("not played, because the experiment before did not complete: {}", fmt::join(rest, ", ")));
  }
  console.next_step("eha runs list " + shell_word(command.output.string()));
  if (!rest.empty()) console.next_step(suggest::run(console.rig(), rest));
  return code;
}

void add_run(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("run", "Play an experiment on a rig, record it, fit and judge its models");
  sub->footer(kRunFooter);
  auto& run = options_of<RunCommand>(*sub, line);
  sub->add_option_function<std::vector<std::string>>(
         "experiment",
         [&run](const std::vector<std::string>& files) {
           run.experiment_file = files.front();
           run.further_files.assign(files.begin() + 1, files.end());
         },
         "Experiment files (TOML), played in this order")
      ->required()
      ->type_name("EXPERIMENT");
  CLI::Option* local = add_drive_options(*sub, run);
  sub->add_flag("--detach", run.detach, "Queue the experiments and leave; not with --local")->excludes(local);
  sub->add_flag("--accept-travel-risk", run.accept_travel_risk,
                "Play even if half of the rehearsed rods reach a limit");
  sub->add_option("--ruler", run.ruler,
                  "Where a ruler shows the rod, such as 2.95in or 75mm; for [characterise] without [following]")
      ->type_name("LENGTH");
}

}  // namespace eha::cli
