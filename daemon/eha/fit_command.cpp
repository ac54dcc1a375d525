// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/fit_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "daemon/control/socket_path.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/fit_next.hpp"
#include "daemon/eha/following_warning.hpp"
#include "daemon/eha/identification_report.hpp"
#include "daemon/eha/import_options.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/eha/model_options.hpp"
#include "daemon/eha/new_folders.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/eha/run_argument.hpp"
#include "daemon/eha/service_text.hpp"
#include "daemon/eha/sheet_answer.hpp"
#include "daemon/eha/sweep_command.hpp"
#include "daemon/eha/track_report.hpp"
#include "daemon/identify/identification.hpp"
#include "daemon/identify/input_trial.hpp"
#include "daemon/identify/intersample_check.hpp"
#include "daemon/identify/judging.hpp"
#include "daemon/identify/publish.hpp"
#include "daemon/identify/source.hpp"
#include "daemon/identify/trip_cause.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_summary.hpp"
#include "daemon/record/sha256.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/reasons.hpp"
#include "ident/validation/record_findings.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;
using identify::Comparisons;
using identify::Identification;
using identify::IdentificationTask;
using identify::Source;

constexpr const char* kFitFooter = R"(
SOURCE is a run folder (its own experiment applies, and its models are replaced unless -o is given) or a file: CSV as
eha or another program writes it, a MAT-file or HDF5; see eha-record(5). Missing facts are guessed, and the guess is
printed in one line; --time, --input, --output and the other options below replace it.
Parameter names: a2 a1 a0 (coefficients), n2 n1 n0 b0 (orders), K, q, delay_s [s], input_bias [input unit]
(with --input-map valve: null, dead_band [input unit], negative_gain_ratio), initial_output [output unit]; with several numerator terms b1 b0 (coefficients), m1 m0 (orders).
With -o DIR each model of a file is written to DIR/<model>.json, whatever its verdict, and the compared samples with
each model's output to DIR/fit.csv, for `eha report`; without -o nothing is written.
Without --model and without models of an experiment the ladder of structures is climbed, each without and with a valve's
map, and one is recommended; see eha(1).
Where the experiment names tones or has repetitions, the measured frequency response is written to
frequency_response.csv, and printed beside the models' with -v; see eha(1).
Exit code 0: a model accepted (good, usable or outdone); 3: none; 4: none converged.

Examples:
  eha fit runs/latest
  eha fit record.csv -o models
  eha fit runs/latest --cross-validate
  eha fit bench.csv --input "Valve [V]" --output "Rod [mm]" --from 2 --to 60
  eha fit record.csv --model io --poles 3 --zeros 1 --delay free --split 0.5
  eha fit record.csv --model io --input-map valve -o models
  eha fit step.csv --model io --input-before 0 -o models
  eha fit record.csv --structure five_terms.toml --model io -o models
  eha fit record.csv --sweep commensurate --poles 2 -o models
  eha fit record.csv --model fo --fix n1=0.9 --bound n2=1.5:2 --decimate 40 -o models)";

const std::vector<std::string> kProcedures{"default", "paper", "both"};
constexpr std::array kInitialStates{Choice<ident::InitialState>{"auto", ident::InitialState::automatic},
                                    Choice<ident::InitialState>{"none", ident::InitialState::none},
                                    Choice<ident::InitialState>{"estimated", ident::InitialState::estimated}};
constexpr std::array kSweeps{Choice<bool>{"commensurate", true}};

std::vector<std::string> family_names() {
  std::vector<std::string> names;
  for (const ident::StructureFamily& family : ident::structure_families()) {
    names.emplace_back(family.name);
  }
  return names;
}

IdentificationTask task_for(const FitCommand& command, const Source& source) {
  IdentificationTask task = identify::task_of(source);
  task.structures = structures_for(command.models, task.structures);
  task.ladder = ladder_for(command.models);
  task.options = with(task.options, command.record, source.record.parts);
  task.is_split_given = command.record.split.has_value();
  task.intersample = source.intersample;
  task.models_folder = command.output.value_or(fs::path());
  task.options.procedure = command.procedure.value_or(task.options.procedure);
  task.options.seed = command.seed.value_or(task.options.seed);
  if (task.options.procedure == ident::Procedure::paper &&
      command.models.initial_state == ident::InitialState::estimated) {
    throw UsageError("--initial-state estimated: the paper's procedure estimates none; leave out one of the two");
  }
  return task;
}

Comparisons comparisons_for(const FitCommand& command, const Source& source) {
  const bool of_experiment = !command.procedure && source.experiment && source.experiment->compares_with_paper;
  return {.paper = command.compares_with_paper || of_experiment ? Comparisons::Paper::include
                                                                : Comparisons::Paper::leave_out,
          .cross_validation =
              command.cross_validate ? Comparisons::CrossValidation::include : Comparisons::CrossValidation::leave_out,
          .ladder = names_models(command.models) ? Comparisons::Ladder::leave_out : Comparisons::Ladder::include};
}

/// Runs `work`. A wrong structure is a usage error unless an experiment file was named.
template <class Work>
auto as_asked_for(const FitCommand& command, const Work& work) {
  try {
    return work();
  } catch (const ConfigError& error) {
    if (command.experiment_file) throw;
    throw UsageError(error.what());
  }
}

std::vector<fs::path> write(const Identification& identification, const FitCommand& command, const Source& source) {
  if (command.output) return identify::write_models(identification, *command.output);
  if (source.run_folder) return identify::publish(identification, source.opened);
  return {};
}

/// Models of two records in one folder would be reported as fits of one.
/// @throws UsageError  the output folder holds a model of another record
void require_own_folder(const FitCommand& command, const Source& source) {
  if (!command.output) return;
  const auto other = model_of_other_record(*command.output, source);
  if (!other) return;
  throw UsageError(fmt::format(
      "-o {}: {} there is a model of another record, {}, and a report would take both for models of one; name another "
      "folder, for instance -o {}",
      command.output->string(), other->file, other->record,
      shell_word(free_name(command.output->string() + "-" + fs::path(command.source).stem().string()))));
}

// For each kind of experiment: runs the computation that its record is for instead of a fit. @returns none: models are
// fitted to it

std::optional<ExitCode> computed_instead(const config::Played&, const FitCommand&, const Source&, Console&) {
  return std::nullopt;
}

/// @throws DataError  always
std::optional<ExitCode> computed_instead(const config::Placing&, const FitCommand& command, const Source&, Console&) {
  throw DataError(fmt::format("{0}: a move of the rod to a place, which no model is fitted to; `eha plot {0}` shows it",
                              shell_word(command.source)));
}

std::optional<ExitCode> computed_instead(const config::SheetRun&, const FitCommand& command, const Source& source,
                                         Console& console) {
  if (!source.run_folder || names_models(command.models)) return std::nullopt;
  return show_valve_sheet(source.opened, SheetFiles::write, std::nullopt, console);
}

/// @throws DataError  models are requested
std::optional<ExitCode> computed_instead(const config::Tracking&, const FitCommand& command, const Source& source,
                                         Console& console) {
  if (source.run_folder && !names_models(command.models)) {
    return show_track(source.opened, TrackFiles::write, console);
  }
  throw DataError(fmt::format(
      "{}: a record in closed loop, whose command contains the noise of its readings; a fit of command and reading "
      "would be biased. `eha track {}` shows gain and lag with the sweep as the instrument; for a model play an "
      "experiment, as `eha design --band` makes one",
      command.source, shell_word(command.source)));
}

/// Says what the recommended model shows of the valve.
ValveNow valve_by(const Identification& identification, const FitCommand& command, const Source& source,
                  Console& console) {
  if (source.run_folder && !command.output) {
    try {
      return warn_of_changed_valve(*source.run_folder, console);
    } catch (const Error& error) {  // a sheet beside it that the caller may not read
      console.debug(error.what());
      return ValveNow::as_known;
    }
  }
  if (source.run_folder && warn_of_leak(*source.run_folder, console, source.units)) return ValveNow::leaks;
  bool is_in_doubt = false;
  for (const identify::IdentifiedModel& model : identification.models) {
    const bool is_recommended = model.result.model.name == identification.recommendation.model;
    if (!is_recommended) continue;
    say_map_note(model.result.model, source.run_folder.value_or(""), console);
    is_in_doubt = source.run_folder && ident::map_shift(model.result.model).has_value();
  }
  if (!is_in_doubt) return ValveNow::as_known;
  try {
    return record::newest_sheet_run(*source.run_folder) ? ValveNow::as_known : ValveNow::changed;
  } catch (const Error& error) {  // a run beside it that cannot be read
    console.debug(error.what());
    return ValveNow::as_known;
  }
}

/// Whether a run tripped by its readings while the rod was within the limit.
bool has_tripped_by_readings(const Source& source) {
  if (source.outcome != acquisition::Outcome::faulted) return false;
  const auto cause = identify::trip_cause(record::read_run(source.opened.files()));
  return cause && cause->is_of_sensor;
}

/// Says before the fit, which may take minutes, what makes it futile.
void warn_of_lost_input(const FitCommand& again, const Source& source, const Console& console) {
  const auto lost = identify::lost_input(source);
  if (!lost) return;
  console.warning(
      fmt::format("{}: {}; this fit is of little use: stop it (Ctrl-C), and {}", source.name, lost->sentence,
                  lost->options.empty()
                      ? fmt::format("look at the record: `{}`", picture_of_record(again))
                      : fmt::format("cut: `{}`", importer::command_with(again.import, again.source, lost->options))));
}

/// Whether the same fit is to be made of the file read otherwise, before anything is said of the plant.
bool mends_columns(ident::FirstStep first) {
  return first == ident::FirstStep::mend_input || first == ident::FirstStep::take_rows_as_even;
}

struct Answered {
  IdentificationTask task;
  Identification identification;
  std::optional<std::string> straight = {};  ///< the fit with an input that is so between the rows, where it may be
};

/// Identifies. Where a file's rows show clearly that its input is straight between them, the source's becomes so.
/// @param again  the command as suggestions repeat it
Answered answer(const FitCommand& command, const FitCommand& again, Source& source, Console& console) {
  const auto of_task = [&](const IdentificationTask& task) {
    Identification found = as_asked_for(command, [&] {
      return identify::identify(source, task, comparisons_for(command, source), console.progress_callback());
    });
    console.end_progress();
    return found;
  };
  const IdentificationTask task = task_for(command, source);
  Identification held = of_task(task);
  // What the input does to noise alone is nothing, and a wrong one does nothing between the rows.
  const ident::FirstStep first = identify::next_step_of(held).first;
  const bool is_unanswered = std::none_of(held.models.begin(), held.models.end(), [](const auto& one) {
    const auto& validation = one.result.model.validation;
    return !validation || validation->score.r2_percent >= ident::kNoAnswer_percent;
  });
  if (first == ident::FirstStep::look_at_sensor || mends_columns(first) || is_unanswered)
    return {task, std::move(held)};
  const auto between = identify::input_between_rows(source, task, held);
  if (between && between->is_straight && !command.record.intersample) {
    console.info(fmt::format("{}: it is taken so (--intersample zoh: as held)", between->seen));
    identify::take_input_as_straight(source);
    const IdentificationTask straight = task_for(command, source);
    return {straight, of_task(straight)};
  }
  // What the user says of the input stands against what is only possible.
  if (!between || (command.record.intersample && !between->is_straight)) return {task, std::move(held)};
  std::string straight = importer::command_with(again.import, again.source, "--intersample foh");
  const std::string advice = identify::advice_of(*between, straight);
  console.warning(advice);
  for (identify::IdentifiedModel& model : held.models) identify::add_remark(model.result.model, advice);
  return {task, std::move(held), std::move(straight)};
}

}  // namespace

ExitCode execute(const FitCommand& command, Console& console) {
  Source source =
      identify::load_source(command.source, command.experiment_file, command.import, console.progress_callback());
  console.end_progress();
  if (command.record.intersample == ident::Intersample::straight) identify::take_input_as_straight(source);
  if (source.run_folder) {
    const bool is_of_service = entry_of_run(*source.run_folder, control::default_socket()).is_object();
    console.set_rig(access_of_run(*source.run_folder, is_of_service));
  } else {
    console.set_rig(access_of_file());
  }
  const FitCommand again = into_new_folder(command);
  suggest::RigAccess rig = console.rig();
  rig.fit = command_of_ladder(again);
  console.set_rig(std::move(rig));
  print_import(source.guess, source.remarks, source.repairs, console);
  std::error_code unknown;
  if (!source.run_folder && fs::is_regular_file(command.source, unknown)) {
    source.sha256 = record::sha256_of_file(command.source);
  }
  if (source.experiment) {
    const auto other = [&](const auto& kind) { return computed_instead(kind, command, source, console); };
    if (const auto code = std::visit(other, source.experiment->kind)) return *code;
  }
  if (source.run_folder && !command.output && !console.quiet()) {
    // The service's own fit is quiet.
    const auto entry = entry_of_run(*source.run_folder, control::default_socket());
    if (const std::string text = progress_text(entry); !text.empty()) {
      console.warning(fmt::format("{}: for the service this run {}; it writes the same models (-o DIR writes others)",
                                  source.run_folder->string(), text));
    }
  }
  if (source.run_folder && !command.output) {
    const fs::path name = fs::path(command.source).filename().empty() ? source.run_folder->filename()
                                                                      : fs::path(command.source).filename();
    require_writable_run(*source.run_folder, again.import.command, "fit-" + name.string());
  }
  const IdentificationTask task = task_for(command, source);
  print_warnings(source, task.options.decimation / source.record.parts, console, [&](int every) {
    return importer::command_with(again.import, again.source, fmt::format("--decimate {}", every));
  });
  warn_of_lost_input(again, source, console);
  if (command.sweep) {
    std::optional<fs::path> folder = command.output;
    os::FileDescriptor models;
    if (!folder && source.run_folder) {
      models = os::open_folder(source.opened.files() / record::kModelsFolder);
      folder = os::path_through(models);
    }
    return as_asked_for(command, [&] { return sweep_commensurate_order(again, task, folder, console); });
  }
  require_own_folder(command, source);
  std::optional<NewFolders> folder;
  if (command.output) folder.emplace(*command.output);
  const Answered answered = answer(command, again, source, console);
  const Identification& identification = answered.identification;
  const ident::FirstStep first = identify::next_step_of(identification).first;
  const auto latest = [&source] {
    std::error_code none;
    return source.run_folder ? fs::read_symlink(source.run_folder->parent_path() / record::kLatestLink, none) : "";
  };
  const fs::path latest_before = latest();
  std::vector<fs::path> written = write(identification, command, source);
  const ValveNow valve = valve_by(identification, command, source, console);
  if (source.run_folder && !command.output && !console.quiet()) {
    const record::Manifest manifest = record::read_manifest(source.opened.files());
    std::string against = record::reason_against_latest(manifest);
    if (against.empty()) against = record::what_stands_for_latest(source.opened);
    if (manifest.identification && manifest.identification->accepted && !against.empty()) {
      console.info(fmt::format("{} stays where it was: {}; name this run instead",
                               (source.run_folder->parent_path() / record::kLatestLink).string(), against));
    } else if (latest() != latest_before && !latest_before.empty()) {
      console.info(fmt::format("{} leads to this run now, and led to {} before",
                               (source.run_folder->parent_path() / record::kLatestLink).string(),
                               latest_before.string()));
    }
  }
  const DisplayUnit unit = console.unit(source.units);
  if (source.run_folder && !command.output) write_report(source.opened, unit, written, console);
  print_identification(identification, written, {{"schema", "eha-fit/1"}, {"source", command.source}}, unit, console);
  if (written.empty()) console.print("Nothing written; -o DIR writes one file per model.");
  const ExitCode code = identify::exit_code(identification.models);
  if (mends_columns(first)) {
    console.next_step(mending_fit(again, source, identification));
    return code;
  }
  const auto cut = cut_command(again, source, identification);
  if (cut) console.next_step(*cut);
  if (first == ident::FirstStep::look_at_sensor || has_tripped_by_readings(source)) {
    console.next_step(source.run_folder ? suggest::read(console.rig()) : picture_of_record(command));
  } else if (first == ident::FirstStep::against_lost_rows) {
    console.next_step("eha doctor");
  } else if (valve == ValveNow::changed) {
    console.next_step(suggest::characterise(console.rig()));
  } else if (const auto next = identify::next_experiment_file(written); next && valve != ValveNow::leaks) {
    console.next_step(suggest::run(console.rig(), {next->string()}));
  } else if (const auto step = step_by_cause(again, source, identification, written); step && !cut) {
    console.next_step(*step);
  } else if (code == ExitCode::ok && !cut) {
    console.next_step(next_of_fit(command, source, identification, written));
  } else if (names_models(command.models) && !climbs_ladder(command.models) &&
             identification.recommendation.model.empty() && !cut) {
    console.next_step(command_of_ladder(again) + (source.run_folder ? fmt::format(" --model {}", kLadder) : ""));
  }
  // Only a possibility, and wrong for an input that was held.
  if (answered.straight && !cut) console.next_step(*answered.straight);
  return code;
}

void add_fit(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("fit", "Fit and judge models on a run or a file");
  sub->footer(kFitFooter);
  auto& fit = options_of<FitCommand>(*sub, line);
  takes_run_name(sub->add_option("source", fit.source, "Run folder or its name, or file with a record"), line)
      ->required()
      ->type_name("SOURCE");
  sub->add_option("--experiment", fit.experiment_file, "Experiment file whose models, record and acceptance apply")
      ->type_name("EXPERIMENT");
  sub->add_option_function<std::string>(
         "--procedure",
         [&fit](const std::string& name) {
           fit.procedure = name == "paper" ? ident::Procedure::paper : ident::Procedure::standard;
           fit.compares_with_paper = name == "both";
         },
         "Procedure; paper: exactly the published one, both: default, compared with the paper")
      ->type_name(fmt::format("{}", fmt::join(kProcedures, "|")))
      ->check(CLI::IsMember(kProcedures).description(""));
  std::vector<std::string> families = family_names();
  families.emplace_back(kLadder);
  std::vector<std::string> names = model_names();
  names.emplace_back(kLadder);
  sub->add_option(
         "--model", fit.models.families,
         "Structure to fit, with _valve behind a valve's map (io_valve); may be repeated; ladder: those of the ladder, "
         "whatever the experiment names (default: the experiment's models, else the ladder)")
      ->type_name(fmt::format("{}", fmt::join(families, "|")))
      ->allow_extra_args(false)
      ->check(CLI::IsMember(names).description(""));
  sub->add_option("--structure", fit.models.structure_files,
                  "TOML file with a structure to fit, term by term; may be repeated")
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
  std::vector<std::string> maps;
  for (const ident::InputMapKind& kind : ident::input_map_kinds()) maps.emplace_back(kind.name);
  sub->add_option("--input-map", fit.models.input_map,
                  "Static map before the model: null, dead band and two gains of a valve (default none)")
      ->type_name(fmt::format("{}", fmt::join(maps, "|")))
      ->check(CLI::IsMember(maps).description(""));
  add_choice(*sub, "--initial-state", fit.models.initial_state, kInitialStates,
             "Response to the input before the first row (default auto)");
  const auto list = [sub](const char* name, std::vector<std::string>& values, const char* help, const char* type) {
    sub->add_option(name, values, help)->type_name(type)->allow_extra_args(false);
  };
  list("--fix", fit.models.fixed, "Hold a parameter; may be repeated", "NAME=VALUE");
  list("--free", fit.models.free, "Estimate a parameter that the structure holds", "NAME");
  list("--start", fit.models.starts, "Start the search there", "NAME=VALUE");
  list("--bound", fit.models.bounds, "Search between these values", "NAME=LOW:HIGH");
  add_record_options(*sub, fit.record);
  sub->add_option("--split", fit.record.split,
                  "Share of the record for estimation, the rest for validation; 1: no validation (default 0.5, or the "
                  "experiment's)")
      ->type_name("FRACTION")
      ->check(finite_number("a fraction above 0, at most 1", [](double x) { return x > 0.0 && x <= 1.0; }));
  sub->add_option("--input-before", fit.record.input_before,
                  "Input before the first row, at which the plant is at rest; for a step at the first row (default 0, "
                  "or the experiment's)")
      ->type_name("VOLTS")
      ->check(finite_number("a finite number", [](double) { return true; }));
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
  sub->add_option("-o", fit.output, "Folder for one model file per model")->type_name("DIR");
  add_choice(*sub, "--sweep", fit.sweep, kSweeps,
             "Fit and stability against the base order q, as a table and DIR/sweep_commensurate.csv")
      ->excludes("--cross-validate");
  sub->add_option("--sweep-orders", fit.sweep_orders, "Base orders of the sweep (default 0.5:1.2:0.05)")
      ->type_name("FIRST:LAST:STEP")
      ->delimiter(':')
      ->expected(3);
  add_import_options(*sub, line, fit.import, ImportedColumns::record);
}

}  // namespace eha::cli
