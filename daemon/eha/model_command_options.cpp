// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/model_command_options.hpp"

#include <fmt/format.h>

#include <array>
#include <string>
#include <vector>

#include "daemon/eha/import_options.hpp"
#include "daemon/eha/option_values.hpp"

namespace eha::cli {
namespace {

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
Where the experiment names tones or has repetitions, the measured frequency response is printed beside the models' and
written to frequency_response.csv; see eha(1).
Exit code 0: a model accepted; 3: all rejected; 4: none converged.

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

constexpr const char* kImportFooter = R"(
Reads a record of another program and writes it as CSV with the columns time_s, input, output; see eha-record(5).
FILE is text (commas, semicolons, tabs, bars or blanks; decimal point or comma; UTF-8, UTF-16, Latin-1; any line ends;
with a header, with a row of units, or without), a MAT-file (version 4, 5, 7.3: arrays, structs of arrays) or HDF5.
Missing facts are guessed, and the guess is printed in one line. An ambiguous file is refused; the message lists its
columns and a command that chooses. --resample fills gaps and lists each of them; filled rows are marked in a column
`filled`.

Examples:
  eha import bench.csv -o record.csv
  eha import bench.mat --time rec.t --input rec.u --output rec.y -o record.csv
  eha import logger.txt --delimiter tab --decimal comma --from 2 --to 60 --resample -o record.csv)";

constexpr const char* kSimulateFooter = R"(
INPUT is a file as for `eha fit`; of several columns the one in the model's unit is the input, held between samples.
An input in another unit is refused. The output is time_s and the model's output.
MODEL needs only `transfer_function`; input_map, input_bias, initial_output and units are used if given. Methods:
  exact  exact for a held input; stable models only
  gl1    Grunwald-Letnikov, first order, as in the paper
  cq2    second-order convolution quadrature; stable models only

Examples:
  eha simulate models/fo.json input.csv -o output.csv
  eha simulate models/io.json input.csv --method gl1)";

constexpr const char* kValidateFooter = R"(
Scores a model on a record it has not seen, with its offset kept and with the offset estimated anew. Shows the residual's
correlations. SOURCE is a run folder or a file, as for `eha fit`; all of it after --discard seconds is scored.
Exit code 0: accepted; 3: rejected.

Examples:
  eha validate models/fo.json runs/latest
  eha validate models/io.json record.csv --decimate 40 --json)";

const std::vector<std::string> kProcedures{"default", "paper", "both"};
constexpr std::array kInitialStates{Choice<ident::InitialState>{"auto", ident::InitialState::automatic},
                                    Choice<ident::InitialState>{"none", ident::InitialState::none},
                                    Choice<ident::InitialState>{"estimated", ident::InitialState::estimated}};
constexpr std::array kMethods{Choice<ident::SimulationMethod>{"exact", ident::SimulationMethod::exact},
                              Choice<ident::SimulationMethod>{"gl1", ident::SimulationMethod::gl1},
                              Choice<ident::SimulationMethod>{"cq2", ident::SimulationMethod::cq2}};
constexpr std::array kSweeps{Choice<bool>{"commensurate", true}};

void add_record_options(CLI::App& app, RecordOptions& record) {
  app.add_option("--decimate", record.decimation, "Compare every Nth sample, filtered (default 1, or the experiment's)")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000).description(""));
  app.add_option("--discard", record.discard_s, "Do not compare the first SECONDS (default 0, or the experiment's)")
      ->type_name("SECONDS")
      ->check(finite_number("seconds >= 0", [](double s) { return s >= 0.0; }));
}

std::vector<std::string> family_names() {
  std::vector<std::string> names;
  for (const ident::StructureFamily& family : ident::structure_families()) {
    names.emplace_back(family.name);
  }
  return names;
}

}  // namespace

void add_fit(CLI::App& app, FitCommand& fit) {
  CLI::App* sub = app.add_subcommand("fit", "Fit and judge models on a run or a file");
  sub->footer(kFitFooter);
  sub->add_option("source", fit.source, "Run folder, or file with a record")->required()->type_name("SOURCE");
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
  const std::vector<std::string> families = family_names();
  sub->add_option("--model", fit.models.families,
                  "Structure to fit; may be repeated (default: the experiment's models, else the ladder)")
      ->type_name(fmt::format("{}", fmt::join(families, "|")))
      ->allow_extra_args(false)
      ->check(CLI::IsMember(families).description(""));
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
  add_import_options(*sub, fit.import, ImportedColumns::record);
}

void add_import(CLI::App& app, ImportCommand& import) {
  CLI::App* sub = app.add_subcommand("import", "Read a record of another program and write it as CSV");
  sub->footer(kImportFooter);
  sub->add_option("file", import.file, "Text, MAT-file or HDF5")->required()->type_name("FILE");
  sub->add_option("-o", import.output, "CSV file to write (default: standard output)")->type_name("FILE");
  add_import_options(*sub, import.import, ImportedColumns::record);
}

void add_simulate(CLI::App& app, SimulateCommand& simulate) {
  CLI::App* sub = app.add_subcommand("simulate", "Simulate a model's output for an input");
  sub->footer(kSimulateFooter);
  sub->add_option("model", simulate.model_file, "Model file (JSON)")->required()->type_name("MODEL");
  sub->add_option("input", simulate.input_file, "File with the input")->required()->type_name("INPUT");
  sub->add_option("-o,--output", simulate.output, "File to write (default: standard output)")->type_name("FILE");
  add_choice(*sub, "--method", simulate.method, kMethods, "How to simulate (default exact)");
  add_import_options(*sub, simulate.import, ImportedColumns::input_only);
}

void add_validate(CLI::App& app, ValidateCommand& validate) {
  CLI::App* sub = app.add_subcommand("validate", "Score a model on a record it has not seen");
  sub->footer(kValidateFooter);
  sub->add_option("model", validate.model_file, "Model file (JSON)")->required()->type_name("MODEL");
  sub->add_option("source", validate.source, "Run folder, or file with a record")->required()->type_name("SOURCE");
  sub->add_option("--experiment", validate.experiment_file, "Experiment file whose record and acceptance apply")
      ->type_name("EXPERIMENT");
  add_record_options(*sub, validate.record);
  add_import_options(*sub, validate.import, ImportedColumns::record);
}

}  // namespace eha::cli
