// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/command_line.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>
#include <string>
#include <string_view>

#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "daemon/doctor/latency.hpp"
#include "daemon/eha/batch_options.hpp"
#include "daemon/eha/completion.hpp"
#include "daemon/eha/drive_options.hpp"
#include "daemon/eha/export_options.hpp"
#include "daemon/eha/model_command_options.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/eha/place_options.hpp"
#include "daemon/eha/report_options.hpp"
#include "daemon/eha/runs_options.hpp"
#include "daemon/eha/service_options.hpp"
#include "daemon/eha/study_options.hpp"
#include "daemon/eha/valve_options.hpp"
#include "daemon/eha/version.hpp"
#include "daemon/eha/web_options.hpp"

namespace eha::cli {
namespace {

constexpr const char* kHelpFooter = R"(
Results go to standard output, messages to standard error.

Exit codes:
  0 ok                  10 bad data              74 input/output error
  1 a bug in eha        11 safety trip           77 permission denied
  2 wrong usage         12 deadline missed       78 wrong configuration
  3 model rejected      69 device or service    130 interrupted
  4 not converged          unavailable

Examples:
  eha run config/experiments/paper.toml --local --fast
  eha fit record.csv --model io --model fo -o models
  eha import bench.mat -o record.csv
  eha simulate models/fo.json input.csv -o output.csv

Every command takes the options above; `eha COMMAND --help` describes its own. Manual pages: eha(1),
eha-experiment(5), eha-rig(5), eha-record(5).)";

constexpr const char* kRunFooter = R"(
Plays the experiment's excitation [V] on the rig every tick, records the displacement [in], fits the experiment's
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

constexpr const char* kCheckFooter = R"(
Reports every fault of a rig.toml or an experiment.toml with its line and column. An experiment is also checked against
the rig that `eha run` would use (--rig, else the default one): limits [V], slew [V/s], Nyquist frequency [Hz]. It is
then rehearsed with the rig's valve, and refused if half of the rehearsed rods reach a travel or velocity limit.

Examples:
  eha check config/experiments/paper.toml
  eha check sweep.toml --rig /etc/ehad/rig.toml)";

constexpr const char* kDesignFooter = R"(
Shows what an experiment would play: peak [V], RMS [V], crest factor, fastest change [V/s], excited lines [Hz].
With -o the table of volts is written as CSV (time_s,voltage_V), one row a tick.
--from with --improve writes the experiment that minimises the standard error of a model's parameter within the rig's
limits of voltage, slew and travel. It shows the predicted standard error, the duration and the limit that binds. On a
simulated rig, or with --twin, each design is tried out: played there and fitted like the real record. --to makes the
experiment as long as the wanted standard error needs, at most 600 s; a message says if that is not enough.
--band writes an experiment (default band.toml) with tones of equal amplitude spread over a band. Their phases keep the
peaks of volts, slew and travel low, their amplitude is the largest within the rig's limits, and the rod is held. With
--odd-random the tones are three of each four odd multiples of 1/period, with other random phases in each realisation:
distortion then shows beside the lines, and at the lines in the spread of the realisations.

Examples:
  eha design config/experiments/paper.toml
  eha design sweep.toml -o sweep.csv
  eha design --from models/fo.json --improve n2 --to 0.05
  eha design --band 0.05:1.5 --tones 30 -o band.toml
  eha design --band 0.1:2 --period 10 --odd-random --realisations 6)";

constexpr const char* kDoctorFooter = R"(
Checks kernel, scheduling, limits, CPUs and disk; for a rig on a card also the device, its driver, board and safety
lines. Each line is ok, warn or fail; warn and fail name the remedy. Nothing is changed and nothing moves.
Exit code, of the worst failure: 78 rig file, 69 device, 77 permission, 74 disk; 0 without a failure.
--following prints the rig file's [following] from a run of the sound rig; 10: the run holds too little.

Examples:
  eha doctor
  eha doctor --rig /etc/ehad/rig.toml --json
  eha doctor --following runs/latest)";

constexpr const char* kLatencyFooter = R"(
Runs the tick loop on the simulated rig in real time and shows how late ticks wake up and how long they take [us].
Passes when 99.9 % wake up within 50 us and all within 150 us, no tick takes over 300 us, and none is skipped.
--rig takes period, priority and CPU of the loop from a rig file; its card is not touched.
Exit code 0: passed; 12: missed.

Examples:
  eha latency
  eha latency --duration 3600 --load)";

void add_run(CLI::App& app, RunCommand& run) {
  CLI::App* sub = app.add_subcommand("run", "Play an experiment on a rig, record it, fit and judge its models");
  sub->footer(kRunFooter);
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
}

void add_check(CLI::App& app, CheckCommand& check) {
  CLI::App* sub = app.add_subcommand("check", "Check a rig or experiment file and report every fault");
  sub->footer(kCheckFooter);
  sub->add_option("file", check.file, "rig.toml or experiment.toml")->required()->type_name("FILE");
  CLI::Option* rig =
      sub->add_option("--rig", check.rig_file, "Rig file to check an experiment against")->type_name("RIG");
  sub->add_option("--at", check.place, "Where the rod stands, such as 2.95in (default: mid-travel)")
      ->type_name("LENGTH")
      ->needs(rig);
  sub->add_flag("--accept-travel-risk", check.accept_travel_risk,
                "Only warn if half of the rehearsed rods reach a limit");
}

void add_design(CLI::App& app, DesignCommand& design) {
  CLI::App* sub = app.add_subcommand(
      "design", "Show or write the excitation of an experiment, or design one that improves a model");
  sub->footer(kDesignFooter);
  sub->add_option("experiment", design.experiment_file,
                  "Experiment file (TOML); with --from it sets duration and [record] and is compared with the design")
      ->type_name("EXPERIMENT");
  sub->add_option("--rig", design.rig_file, "Rig file whose tick and limits apply")->type_name("RIG");
  sub->add_option("-o,--output", design.output,
                  "CSV file to write the table of volts to; with --from the experiment (default improve-NAME.toml)")
      ->type_name("FILE");
  CLI::Option* from =
      sub->add_option("--from", design.model_file, "Model file to improve, as `eha fit` wrote it")->type_name("MODEL");
  CLI::Option* improve =
      sub->add_option("--improve", design.parameter, "Parameter whose standard error is to become small")
          ->type_name("NAME")
          ->needs(from);
  from->needs(improve);
  CLI::Option* band = sub->add_option_function<std::string>(
                             "--band", [&design](const std::string& text) { design.band = band_of(text); },
                             "Write an experiment with tones of equal amplitude in this band [Hz]")
                          ->type_name("LOW:HIGH")
                          ->excludes(from);
  CLI::Option* odd_random = sub->add_flag_callback(
                                   "--odd-random", [&design] { design.realisations = design.realisations.value_or(6); },
                                   "Fill the band with odd lines of random phases, which separate noise and distortion")
                                ->needs(band);
  sub->add_option("--realisations", design.realisations, "Realisations of other phases, 2 to 50 (default 6)")
      ->type_name("M")
      ->needs(odd_random)
      ->check(CLI::Range(2, 50).description(""));
  sub->add_option("--tones", design.tones, "Tones in the band, 2 to 500 (default 30)")
      ->type_name("N")
      ->needs(band)
      ->excludes(odd_random)
      ->check(CLI::Range(2, 500).description(""));
  sub->add_option("--period", design.period_s, "Period of the tones, 1 to 1000 s (default 20); 1/period is their grid")
      ->type_name("SECONDS")
      ->needs(band)
      ->check(finite_number("seconds from 1 to 1000", [](double s) { return s >= 1.0 && s <= 1000.0; }));
  sub->add_option("--twin", design.twin_file,
                  "Simulated rig that predicts, as `eha replay --calibrate` writes it (default: --rig where simulated)")
      ->type_name("RIG")
      ->needs(from);
  sub->add_option("--to", design.wanted_std, "Wanted standard error; the experiment becomes as long as that takes")
      ->type_name("STD")
      ->needs(from)
      ->check(finite_number("a number above 0", [](double s) { return s > 0.0; }));
}

void add_doctor(CLI::App& app, DoctorCommand& doctor) {
  CLI::App* sub = app.add_subcommand("doctor", "Check that this machine and its rig are fit for experiments");
  sub->footer(kDoctorFooter);
  CLI::Option* rig = sub->add_option("--rig", doctor.rig_file, "Rig file (TOML)")->type_name("RIG");
  CLI::Option* output =
      sub->add_option("--output", doctor.output, "Folder that run folders would be put into (default runs)")
          ->type_name("DIR");
  sub->add_option("--following", doctor.following, "Print [following] for the rig file, learnt from a completed run")
      ->type_name("RUN")
      ->excludes(rig)
      ->excludes(output);
}

void add_latency(CLI::App& app, LatencyCommand& latency) {
  CLI::App* sub = app.add_subcommand("latency", "Measure how well the tick loop keeps time on this machine");
  sub->footer(kLatencyFooter);
  sub->add_option("--duration", latency.duration_s, "How long to measure, 0.1 to 65535 s (default 60)")
      ->type_name("SECONDS")
      ->check(finite_number("seconds from 0.1 to 65535", [](double s) {
        return s >= doctor::kShortestMeasurement_s && s <= doctor::kLongestMeasurement_s;
      }));
  sub->add_flag("--load", latency.load, "Keep every CPU and the memory busy meanwhile");
  sub->add_option("--rig", latency.rig_file, "Rig file whose period, priority and CPU apply")->type_name("RIG");
}

/// The command line, quoted for a shell.
std::string for_a_shell(int argc, const char* const* argv) {
  std::string line = "eha";
  for (int i = 1; i < argc; ++i) line += " " + shell_word(argv[i]);
  return line;
}

/// The struct that each command fills.
struct Commands {
  RunCommand run;
  FitCommand fit;
  ImportCommand import;
  SimulateCommand simulate;
  ValidateCommand validate;
  ExportCommand export_;
  CompareCommand compare;
  ReplayCommand replay;
  ReportCommand report;
  PlotCommand plot;
  BatchCommands batch;
  CheckCommand check;
  DesignCommand design;
  RunsCommands runs;
  DoctorCommand doctor;
  LatencyCommand latency;
  PlaceCommands place;
  CharacteriseCommand characterise;
  CalibrateCommand calibrate;
  ReadCommand read;
  StudyCommand study;
  ServiceCommand service;
  WebCommand web;
  std::string shell;  ///< of completion
};

void add_commands(CLI::App& app, Commands& commands) {
  add_run(app, commands.run);
  add_fit(app, commands.fit);
  add_import(app, commands.import);
  add_simulate(app, commands.simulate);
  add_validate(app, commands.validate);
  add_export(app, commands.export_);
  add_compare(app, commands.compare);
  add_replay(app, commands.replay);
  add_report(app, commands.report);
  add_plot(app, commands.plot);
  add_batch(app, commands.batch);
  add_check(app, commands.check);
  add_design(app, commands.design);
  add_runs(app, commands.runs);
  add_doctor(app, commands.doctor);
  add_latency(app, commands.latency);
  add_study(app, commands.study);
  add_completion(app, commands.shell);
  add_read(app, commands.read);
  add_place_commands(app, commands.place);
  add_characterise(app, commands.characterise);
  add_calibrate(app, commands.calibrate);
  add_service_commands(app, commands.service);
  add_web(app, commands.web);
}

void add_common_options(CLI::App& app, ConsoleOptions& console) {
  app.footer(kHelpFooter);
  app.require_subcommand(1);
  app.fallthrough();
  app.set_help_flag("-h,--help", "Print this help and leave");
  app.set_version_flag("--version", "", "Print the versions of eha and its libraries and leave");
  app.add_flag("--json", console.json, "Results on standard output as one JSON document");
  app.add_flag("-q,--quiet", console.quiet, "Errors only");
  app.add_flag("-v,--verbose", console.verbose, "More messages, and every figure of a result");
  std::vector<std::string> units;
  for (const LengthUnit& unit : kLengthUnits) units.emplace_back(unit.name);
  app.add_option("--units", console.units, "Unit of lengths for people (default: the rig file's, else the record's)")
      ->type_name(fmt::format("{}", fmt::join(units, "|")))
      ->check(CLI::IsMember(units).description(""));
  app.add_flag("--no-progress", console.no_progress, "No progress bar on a terminal (NO_COLOR: no colours)");
}

/// The command that was given; none for `completion`.
std::optional<Command> chosen_command(const CLI::App& app, const Commands& commands) {
  if (app.got_subcommand("run")) return commands.run;
  if (app.got_subcommand("fit")) return commands.fit;
  if (app.got_subcommand("import")) return commands.import;
  if (app.got_subcommand("simulate")) return commands.simulate;
  if (app.got_subcommand("validate")) return commands.validate;
  if (app.got_subcommand("export")) return commands.export_;
  if (app.got_subcommand("compare")) return commands.compare;
  if (app.got_subcommand("replay")) return commands.replay;
  if (app.got_subcommand("report")) return commands.report;
  if (app.got_subcommand("plot")) return commands.plot;
  if (const CLI::App* sub = app.get_subcommand("batch"); sub->parsed()) {
    if (sub->got_subcommand("merge")) return commands.batch.merge;
    return commands.batch.batch;
  }
  if (app.got_subcommand("check")) return commands.check;
  if (app.got_subcommand("design")) return commands.design;
  if (app.got_subcommand("doctor")) return commands.doctor;
  if (app.got_subcommand("latency")) return commands.latency;
  if (app.got_subcommand("read")) return commands.read;
  if (app.got_subcommand("study")) return commands.study;
  if (app.got_subcommand("characterise")) return commands.characterise;
  if (app.got_subcommand("calibrate")) return commands.calibrate;
  if (app.got_subcommand("goto")) return commands.place.go_to;
  if (app.got_subcommand("jog")) return commands.place.jog;
  if (app.got_subcommand("web")) return commands.web;
  if (!commands.service.method.empty()) return commands.service;
  if (const CLI::App* sub = app.get_subcommand("runs"); sub->parsed()) {
    if (sub->got_subcommand("list")) return commands.runs.list;
    if (sub->got_subcommand("show")) return commands.runs.show;
    if (sub->got_subcommand("recover")) return commands.runs.recover;
    if (sub->got_subcommand("cancel")) return commands.runs.cancel;
    if (sub->got_subcommand("ack")) return commands.runs.ack;
    if (sub->got_subcommand("remove")) return commands.runs.remove;
  }
  return std::nullopt;
}

/// The message of a wrong command line, with the help to read.
std::string usage_message(const CLI::App& app, const CLI::ParseError& error) {
  std::string command = "eha";
  for (const CLI::App* sub = &app; !sub->get_subcommands().empty();) {
    sub = sub->get_subcommands().back();
    command += " " + sub->get_name();
  }
  const bool unknown = app.get_subcommands().empty() && app.remaining_size() > 0;
  const std::string what = unknown ? "unknown command or option \"" + app.remaining().front() + "\"" : error.what();
  return what + "; see `" + command + " --help`";
}

}  // namespace

ParsedLine parse_command_line(int argc, const char* const* argv) {
  ParsedLine parsed;
  Commands commands;
  CLI::App app("eha - from an electro-hydraulic actuator rig to validated models", "eha");
  add_common_options(app, parsed.console);
  add_commands(app, commands);
  // What follows -- in a batch's line is the line of `eha fit`.
  const auto separator = std::find(argv, argv + argc, std::string_view("--"));
  const bool is_batch = std::find(argv, separator, std::string_view("batch")) != separator;
  if (is_batch && separator != argv + argc) commands.batch.batch.fit_options.assign(separator + 1, argv + argc);
  try {
    app.parse(is_batch ? static_cast<int>(separator - argv) : argc, argv);
  } catch (const CLI::CallForHelp&) {
    parsed.text = app.help();
    return parsed;
  } catch (const CLI::CallForVersion&) {
    parsed.text = version_text();
    return parsed;
  } catch (const CLI::ParseError& error) {
    throw UsageError(usage_message(app, error));
  }
  const std::string as_given = for_a_shell(argc, argv);
  for (importer::Options* options :
       {&commands.fit.import, &commands.import.import, &commands.simulate.import, &commands.validate.import}) {
    options->command = as_given;
  }
  parsed.command = chosen_command(app, commands);
  if (app.got_subcommand("completion")) parsed.text = completion_script(app, commands.shell);
  return parsed;
}

}  // namespace eha::cli
