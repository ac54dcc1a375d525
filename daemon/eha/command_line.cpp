// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/doctor/latency.hpp"
#include "daemon/eha/completion.hpp"
#include "daemon/eha/runs_options.hpp"
#include "daemon/eha/service_options.hpp"

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
  eha simulate models/fo.json input.csv -o output.csv

`eha COMMAND --help` tells more, and every command takes the options above. All there is to say stands in eha(1),
eha-experiment(5), eha-rig(5) and eha-record(5).)";

constexpr const char* kRunFooter = R"(
Plays the experiment's excitation [V] on the rig every tick, records the displacement [in], fits the experiment's
models and judges them. The run folder OUTPUT/<UTC time>-<name> holds run.json, raw.ehalog, raw.h5, data_40ms.csv,
frequency_response.csv and models/*.json; a rejected model goes to models/rejected. OUTPUT/latest points to the last
run with an accepted model.
One Ctrl-C ramps the command down and keeps what was recorded; a second one makes the rig safe at once.
Without --local the service ehad does all this with its own rig file, in its own folder, once its queue and the lease
(`eha arm`) allow; losing the connection does not stop the run, Ctrl-C does.

Examples:
  eha arm && eha run config/experiments/paper.toml
  eha run config/experiments/paper.toml --local --fast
  eha run sweep.toml --local --rig rig.toml --output /data/runs)";

constexpr const char* kFitFooter = R"(
SOURCE is a run folder (its experiment says how, its models are published anew unless -o is given) or a CSV record
with the columns time_s, input, output, units as suffixes (voltage_V,displacement_in); see eha-record(5).
Parameter names: a2 a1 a0 (coefficients), n2 n1 n0 b0 (orders), K, q, delay_s [s], input_bias [input unit],
initial_output [output unit]; with several numerator terms b1 b0 (coefficients), m1 m0 (orders).
Each model of a CSV record is written to DIR/<model>.json with -o DIR, whatever its verdict; without -o nothing is
written.
Where the experiment names tones or has repetitions, the measured frequency response is printed beside the models' and
written to frequency_response.csv; see eha(1).
Exit code 0: a model accepted; 3: all rejected; 4: none converged.

Examples:
  eha fit runs/latest
  eha fit runs/latest --cross-validate
  eha fit record.csv --model io --poles 3 --zeros 1 --delay free --split 0.5
  eha fit record.csv --structure five_terms.toml --model io -o models
  eha fit record.csv --sweep commensurate --poles 2 -o models
  eha fit record.csv --model fo --fix n1=0.9 --bound n2=1.5:2 --decimate 40 -o models)";

constexpr const char* kSimulateFooter = R"(
INPUT has time_s [s] first and the input last, held between samples. The output is time_s and the model's output.
MODEL needs only `transfer_function`; input_bias, initial_output and units are used where given. Methods:
  exact  exact for a held input; stable models only
  gl1    Grunwald-Letnikov, first order, as in the paper
  cq2    second-order convolution quadrature; stable models only

Examples:
  eha simulate models/fo.json input.csv -o output.csv
  eha simulate models/io.json input.csv --method gl1)";

constexpr const char* kValidateFooter = R"(
Scores a model on a record it has not seen, its offset kept and estimated anew, with the residual's correlations.
SOURCE is a run folder or a CSV record, as for `eha fit`; the whole of it is scored, after --discard seconds.
Exit code 0: accepted; 3: rejected.

Examples:
  eha validate models/fo.json runs/latest
  eha validate models/io.json record.csv --decimate 40 --json)";

constexpr const char* kCheckFooter = R"(
Reports every fault of a rig.toml or an experiment.toml with its line and column. An experiment is also held against
the rig that `eha run` would use (--rig, else the default one): limits [V], slew [V/s], Nyquist frequency [Hz].

Examples:
  eha check config/experiments/paper.toml
  eha check sweep.toml --rig /etc/ehad/rig.toml)";

constexpr const char* kDesignFooter = R"(
Shows what an experiment would play: peak [V], RMS [V], crest factor, fastest change [V/s], excited lines [Hz].
With -o the table of volts is written as CSV (time_s,voltage_V), one row a tick.

Examples:
  eha design config/experiments/paper.toml
  eha design sweep.toml -o sweep.csv)";

constexpr const char* kDoctorFooter = R"(
Looks at kernel, scheduling, limits, CPUs and disk, and with a rig on a card at the device, its driver, board and safety
lines. Each line is ok, warn or fail, the last two with what mends it. Nothing is changed and nothing moves.
Exit code, of the worst failure: 78 rig file, 69 device, 77 permission, 74 disk; 0 without a failure.

Examples:
  eha doctor
  eha doctor --rig /etc/ehad/rig.toml --json)";

constexpr const char* kLatencyFooter = R"(
Runs the tick loop on the simulated rig in real time and shows how late ticks wake up and how long they take [us].
Passes when 99.9 % wake up within 50 us and all within 150 us, no tick takes over 300 us, and none is skipped.
--rig takes period, priority and CPU of the loop from a rig file; its card is not touched.
Exit code 0: passed; 12: missed.

Examples:
  eha latency
  eha latency --duration 3600 --load)";

/// Options whose text is turned into values after parsing.
struct Texts {
  std::string procedure;
  std::string initial_state;
  std::string method = "exact";
  std::string sweep;
  std::string shell;
};

CLI::Validator finite_number(const std::string& range, bool (*accept)(double)) {
  return CLI::Validator(
      [range, accept](std::string& text) {
        double value = 0.0;
        if (!CLI::detail::lexical_cast(text, value) || !std::isfinite(value) || !accept(value)) {
          return "expected " + range + ", got " + text;
        }
        return std::string();
      },
      "");
}

void add_record_options(CLI::App& app, RecordOptions& record) {
  app.add_option("--decimate", record.decimation, "Compare every Nth sample, filtered (default 1, or the experiment's)")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000).description(""));
  app.add_option("--discard", record.discard_s, "Do not compare the first SECONDS (default 0, or the experiment's)")
      ->type_name("SECONDS")
      ->check(finite_number("seconds >= 0", [](double s) { return s >= 0.0; }));
}

void add_run(CLI::App& app, RunCommand& run) {
  CLI::App* sub = app.add_subcommand("run", "Play an experiment on a rig, record it, fit and judge its models");
  sub->footer(kRunFooter);
  sub->add_option("experiment", run.experiment_file, "Experiment file (TOML)")->required()->type_name("EXPERIMENT");
  CLI::Option* local = sub->add_flag("--local", run.local, "Run in this process instead of through ehad");
  add_socket_option(*sub, run.socket)->excludes(local);
  sub->add_option("--rig", run.rig_file, "Rig file (TOML); with --local only")->type_name("RIG")->needs(local);
  sub->add_flag("--fast", run.fast, "Virtual time: as fast as this machine computes; simulated rigs only");
  sub->add_option("--output", run.output, "Folder that the run folder is put into (default runs); with --local only")
      ->type_name("DIR")
      ->needs(local);
  sub->add_flag("--yes", run.yes, "Move a real actuator without asking");
  sub->add_flag("--allow-non-realtime", run.allow_non_realtime,
                "Run without real-time privileges too, for test benches; with --local only")
      ->needs(local);
}

/// @param with_degrees  only those that have poles and zeros
std::vector<std::string> family_names(bool with_degrees) {
  std::vector<std::string> names;
  for (const ident::StructureFamily& family : ident::structure_families()) {
    if (family.has_degrees || !with_degrees) names.emplace_back(family.name);
  }
  return names;
}

void add_fit(CLI::App& app, FitCommand& fit, Texts& texts) {
  CLI::App* sub = app.add_subcommand("fit", "Fit and judge models on a run or a CSV record");
  sub->footer(kFitFooter);
  sub->add_option("source", fit.source, "Run folder or CSV record")->required()->type_name("SOURCE");
  sub->add_option("--experiment", fit.experiment_file, "Experiment file whose models, record and acceptance apply")
      ->type_name("EXPERIMENT");
  sub->add_option("--procedure", texts.procedure, "How to fit; paper is the published procedure to the letter")
      ->type_name("default|paper")
      ->check(CLI::IsMember({"default", "paper"}).description(""));
  const std::vector<std::string> families = family_names(false);
  sub->add_option("--model", fit.models.families,
                  "What to fit; may be repeated (default io and fo, or the experiment's)")
      ->type_name(fmt::format("{}", fmt::join(families, "|")))
      ->allow_extra_args(false)
      ->check(CLI::IsMember(families).description(""));
  sub->add_option("--structure", fit.models.structure_files,
                  "Fit the structure that this file gives term by term (TOML); may be repeated")
      ->type_name("FILE")
      ->allow_extra_args(false);
  sub->add_option("--poles", fit.models.poles, "Poles of io, degree of commensurate: 1..10 (default 2)")
      ->type_name("N")
      ->check(CLI::Range(1, 10).description(""));
  sub->add_option("--zeros", fit.models.zeros, "Zeros of io, numerator degree of commensurate (default 0)")
      ->type_name("N")
      ->check(CLI::Range(0, 10).description(""));
  sub->add_option("--delay", fit.models.delay, "Transport delay: free, or SECONDS to hold it at (default 0)")
      ->type_name("free|SECONDS");
  sub->add_option("--initial-state", texts.initial_state, "Response to what came before the first row (default auto)")
      ->type_name("auto|none|estimated")
      ->check(CLI::IsMember({"auto", "none", "estimated"}).description(""));
  const auto list = [sub](const char* name, std::vector<std::string>& values, const char* help, const char* type) {
    sub->add_option(name, values, help)->type_name(type)->allow_extra_args(false);
  };
  list("--fix", fit.models.fixed, "Hold a parameter; may be repeated", "NAME=VALUE");
  list("--free", fit.models.free, "Estimate a parameter that the structure holds", "NAME");
  list("--start", fit.models.starts, "Start the search there", "NAME=VALUE");
  list("--bound", fit.models.bounds, "Search between these values", "NAME=LOW:HIGH");
  add_record_options(*sub, fit.record);
  sub->add_option("--split", fit.record.split,
                  "Share of the record that estimates, the rest validates; 1 for all "
                  "(default 0.5, or the experiment's)")
      ->type_name("FRACTION")
      ->check(finite_number("a fraction above 0, at most 1", [](double x) { return x > 0.0 && x <= 1.0; }));
  sub->add_option("--seed", fit.seed, "Seed of the search's starting points (default 1, or the experiment's)")
      ->type_name("N")
      // Without this a sign would wrap around to a huge seed.
      ->check(CLI::Validator(
          [](std::string& text) {
            const bool digits = text.find_first_not_of("0123456789") == std::string::npos;
            return digits ? std::string() : "expected a whole number >= 0, got " + text;
          },
          ""));
  sub->add_flag("--cross-validate", fit.cross_validate,
                "Also estimate on each repetition of a run and score on the others");
  sub->add_option("-o,--output", fit.output, "Folder for one model file per model")->type_name("DIR");
  sub->add_option("--sweep", texts.sweep,
                  "Fit and stability against the base order q, as a table and DIR/sweep_commensurate.csv")
      ->type_name("commensurate")
      ->check(CLI::IsMember({"commensurate"}).description(""))
      ->excludes("--cross-validate");
  sub->add_option("--sweep-orders", fit.sweep_orders, "Base orders of the sweep (default 0.5:1.2:0.05)")
      ->type_name("FIRST:LAST:STEP")
      ->delimiter(':')
      ->expected(3);
}

void add_simulate(CLI::App& app, SimulateCommand& simulate, Texts& texts) {
  CLI::App* sub = app.add_subcommand("simulate", "Simulate a model's output for an input");
  sub->footer(kSimulateFooter);
  sub->add_option("model", simulate.model_file, "Model file (JSON)")->required()->type_name("MODEL");
  sub->add_option("input", simulate.input_file, "Input (CSV)")->required()->type_name("INPUT");
  sub->add_option("-o,--output", simulate.output, "File to write (default: standard output)")->type_name("FILE");
  sub->add_option("--method", texts.method, "How to simulate (default exact)")->type_name("exact|gl1|cq2");
}

void add_validate(CLI::App& app, ValidateCommand& validate) {
  CLI::App* sub = app.add_subcommand("validate", "Score a model on a record it has not seen");
  sub->footer(kValidateFooter);
  sub->add_option("model", validate.model_file, "Model file (JSON)")->required()->type_name("MODEL");
  sub->add_option("source", validate.source, "Run folder or CSV record")->required()->type_name("SOURCE");
  sub->add_option("--experiment", validate.experiment_file, "Experiment file whose record and acceptance apply")
      ->type_name("EXPERIMENT");
  add_record_options(*sub, validate.record);
}

void add_check(CLI::App& app, CheckCommand& check) {
  CLI::App* sub = app.add_subcommand("check", "Check a rig or experiment file and report every fault");
  sub->footer(kCheckFooter);
  sub->add_option("file", check.file, "rig.toml or experiment.toml")->required()->type_name("FILE");
  sub->add_option("--rig", check.rig_file, "Rig file to hold an experiment against")->type_name("RIG");
}

void add_design(CLI::App& app, DesignCommand& design) {
  CLI::App* sub = app.add_subcommand("design", "Show or write the excitation of an experiment");
  sub->footer(kDesignFooter);
  sub->add_option("experiment", design.experiment_file, "Experiment file (TOML)")->required()->type_name("EXPERIMENT");
  sub->add_option("--rig", design.rig_file, "Rig file whose tick and limits apply")->type_name("RIG");
  sub->add_option("-o,--output", design.output, "CSV file to write the table of volts to")->type_name("FILE");
}

void add_doctor(CLI::App& app, DoctorCommand& doctor) {
  CLI::App* sub = app.add_subcommand("doctor", "Check that this machine and its rig are fit for experiments");
  sub->footer(kDoctorFooter);
  sub->add_option("--rig", doctor.rig_file, "Rig file (TOML)")->type_name("RIG");
  sub->add_option("--output", doctor.output, "Folder that run folders would be put into (default runs)")
      ->type_name("DIR");
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

void interpret(const Texts& texts, FitCommand& fit, SimulateCommand& simulate) {
  if (!texts.procedure.empty()) {
    fit.procedure = texts.procedure == "paper" ? ident::Procedure::paper : ident::Procedure::standard;
  }
  if (!texts.initial_state.empty()) {
    fit.models.initial_state = texts.initial_state == "none"        ? ident::InitialState::none
                               : texts.initial_state == "estimated" ? ident::InitialState::estimated
                                                                    : ident::InitialState::automatic;
  }
  fit.sweep = !texts.sweep.empty();
  simulate.method = ident::simulation_method(texts.method);
}

/// The command as a shell would read it again.
std::string for_a_shell(int argc, const char* const* argv) {
  std::string line = "eha";
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool plain = !word.empty() && word.find_first_of(" \t\n'\"\\$`*?[]{}()<>|&;#~!") == std::string::npos;
    std::string quoted = "'";
    for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += " " + (plain ? word : quoted + "'");
  }
  return line;
}

}  // namespace

ParsedLine parse_command_line(int argc, const char* const* argv) {
  ParsedLine parsed;
  Texts texts;
  RunCommand run;
  FitCommand fit;
  SimulateCommand simulate;
  ValidateCommand validate;
  CheckCommand check;
  DesignCommand design;
  RunsCommands runs;
  DoctorCommand doctor;
  LatencyCommand latency;
  ServiceCommand service;

  CLI::App app("eha - from an electro-hydraulic actuator rig to validated models", "eha");
  app.footer(kHelpFooter);
  app.require_subcommand(1);
  app.fallthrough();
  app.set_help_flag("-h,--help", "Print this help and leave");
  app.set_version_flag("--version", "", "Print the versions of eha and its libraries and leave");
  app.add_flag("--json", parsed.console.json, "Results on standard output as one JSON document");
  app.add_flag("-q,--quiet", parsed.console.quiet, "Errors only");
  app.add_flag("-v,--verbose", parsed.console.verbose, "More messages");
  app.add_flag("--no-progress", parsed.console.no_progress, "No progress bar on a terminal (NO_COLOR: no colours)");
  add_run(app, run);
  add_fit(app, fit, texts);
  add_simulate(app, simulate, texts);
  add_validate(app, validate);
  add_check(app, check);
  add_design(app, design);
  add_runs(app, runs);
  add_doctor(app, doctor);
  add_latency(app, latency);
  add_completion(app, texts.shell);
  add_service_commands(app, service);

  try {
    app.parse(argc, argv);
    interpret(texts, fit, simulate);
  } catch (const CLI::CallForHelp&) {
    parsed.text = app.help();
    return parsed;
  } catch (const CLI::CallForVersion&) {
    parsed.text = version_text();
    return parsed;
  } catch (const CLI::ParseError& error) {
    std::string command = "eha";
    for (const CLI::App* sub = &app; !sub->get_subcommands().empty();) {
      sub = sub->get_subcommands().back();
      command += " " + sub->get_name();
    }
    const bool unknown = app.get_subcommands().empty() && app.remaining_size() > 0;
    const std::string what = unknown ? "unknown command or option \"" + app.remaining().front() + "\"" : error.what();
    throw UsageError(what + "; see `" + command + " --help`");
  }

  if (app.got_subcommand("completion")) parsed.text = completion_script(app, texts.shell);
  if (app.got_subcommand("run")) parsed.command = run;
  fit.as_given = for_a_shell(argc, argv);
  if (app.got_subcommand("fit")) parsed.command = fit;
  if (app.got_subcommand("simulate")) parsed.command = simulate;
  if (app.got_subcommand("validate")) parsed.command = validate;
  if (app.got_subcommand("check")) parsed.command = check;
  if (app.got_subcommand("design")) parsed.command = design;
  if (app.got_subcommand("doctor")) parsed.command = doctor;
  if (app.got_subcommand("latency")) parsed.command = latency;
  if (!service.method.empty()) parsed.command = service;
  if (const CLI::App* sub = app.get_subcommand("runs"); sub->parsed()) {
    if (sub->got_subcommand("list")) parsed.command = runs.list;
    if (sub->got_subcommand("show")) parsed.command = runs.show;
    if (sub->got_subcommand("recover")) parsed.command = runs.recover;
    if (sub->got_subcommand("cancel")) parsed.command = runs.cancel;
    if (sub->got_subcommand("ack")) parsed.command = runs.ack;
    if (sub->got_subcommand("remove")) parsed.command = runs.remove;
  }
  return parsed;
}

}  // namespace eha::cli
