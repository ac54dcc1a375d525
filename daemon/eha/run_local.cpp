// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/run_local.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/characterisation.hpp"
#include "config/prepared_experiment.hpp"
#include "config/tone_grid.hpp"
#include "core/display_unit.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/rehearsal_text.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/ruler.hpp"
#include "daemon/eha/run_command.hpp"
#include "daemon/eha/run_line.hpp"
#include "daemon/eha/run_outcome.hpp"
#include "daemon/eha/run_service.hpp"
#include "daemon/eha/sleep_delay.hpp"
#include "daemon/eha/stop_on_signals.hpp"
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
#include "daemon/rig/watched_lines.hpp"
#include "hal/backends/backend.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;

/// A checked experiment of the command line.
struct PlannedRun {
  std::string file;
  config::PreparedExperiment experiment;
  std::optional<double> margin_in = {};  ///< predicted distance to the nearer travel limit [in]
};

/// What the runs of one command leave for the next one.
struct EarlierRuns {
  acquisition::EarlierRuns counted = {};
  std::optional<play::FinishedRun> last = {};
};

/// Of a machine all runs of this process, so that a command of several steps, as eha commission, knows where the one
/// before left the rod. A simulated rod begins anew.
EarlierRuns& earlier_runs_on(const config::RigConfig& rig, EarlierRuns& own) {
  static EarlierRuns of_machine;
  return hal::moves_machine(rig.backend) ? of_machine : own;
}

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
      with_watched_lines(
          local.rig(), [&] { margin_in = rehearsed_margin(planned, rig_config, place_in, risk_of(command), console); });
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
      .earlier = &earlier.counted,
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

/// Plays several, until one does not end as it should.
ExitCode play_in_turn(const RunCommand& command, const config::RigConfig& rig, const std::vector<PlannedRun>& planned,
                      Console& console) {
  console.keep_documents();
  EarlierRuns of_command;
  EarlierRuns& earlier = earlier_runs_on(rig, of_command);
  ExitCode code = ExitCode::ok;
  std::vector<std::string> rest;
  // A machine is not left unwatched for the fit of a run before the next one is played.
  const std::size_t at_once = hal::moves_machine(rig.backend) ? planned.size() : 1;
  std::size_t begun = 0;
  bool was_stopped = false;
  bool is_forbidden = false;  // by a line of the rig
  std::optional<std::pair<std::string, ExitCode>> refusal;
  for (bool goes_on = true; goes_on && begun < planned.size();) {
    std::vector<Acquired> acquired;
    for (; goes_on && begun < planned.size() && acquired.size() < at_once;
         goes_on = goes_on && is_sound(acquired.back())) {
      const PlannedRun& one = planned[begun];
      console.set_subject(one.file);
      try {
        acquired.push_back(record_one(command, rig, one, earlier, console));
        was_stopped = acquired.back().was_stopped;
        is_forbidden = acquired.back().run.circuit != acquisition::CircuitAtRest::sound;
        ++begun;
      } catch (const Error& error) {
        if (acquired.empty()) throw;
        // Said after those that were played.
        refusal = {error.what(), error.exit_code()};
        goes_on = false;
        break;
      }
    }
    for (std::size_t i = 0; i < acquired.size(); ++i) {
      const PlannedRun& one = planned[begun - acquired.size() + i];
      console.print(one.file + ":");
      console.set_subject(one.file);
      ExitCode own = ExitCode::ok;
      try {
        own = conclude(command, rig, one.experiment.config, acquired[i], console);
      } catch (const Error& error) {
        console.error(error.what());  // those after it are played, too
        own = error.exit_code();
      }
      if (code == ExitCode::ok) code = own;
    }
  }
  if (refusal) {
    console.set_subject(planned[begun].file);
    console.error(refusal->first);
    code = refusal->second;
  } else if (begun < planned.size() && code == ExitCode::ok) {
    code = was_stopped ? ExitCode::interrupted : ExitCode::safety_trip;
  }
  for (std::size_t i = begun; i < planned.size(); ++i) rest.push_back(planned[i].file);
  const nlohmann::ordered_json documents = console.taken_documents();
  console.print_json({{"schema", "eha-run-list/1"}, {"runs", documents}, {"exit_code", static_cast<int>(code)}});
  if (!rest.empty()) {
    console.set_subject("");
    const char* why = "the experiment before did not complete";
    if (refusal) why = "the first of them was refused";
    if (is_forbidden) why = "of what the rig's lines showed after the experiment before";
    console.info(fmt::format("not played, because {}: {}", why, fmt::join(rest, ", ")));
  }
  console.next_step("eha runs list " + shell_word(command.output.string()));
  if (!rest.empty()) console.next_step(suggest::run(console.rig(), rest));
  return code;
}

}  // namespace

ExitCode run_in_this_process(const RunCommand& command, Console& console) {
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
  if (planned.size() > 1) return play_in_turn(command, rig, planned, console);
  EarlierRuns of_command;
  EarlierRuns& earlier = earlier_runs_on(rig, of_command);
  const Acquired acquired = record_one(command, rig, planned.front(), earlier, console);
  return conclude(command, rig, planned.front().experiment.config, acquired, console);
}

}  // namespace eha::cli
