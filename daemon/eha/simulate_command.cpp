// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/import_options.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/eha/model_options.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/eha/run_argument.hpp"
#include "daemon/eha/simulated_start.hpp"
#include "daemon/identify/record_units.hpp"
#include "daemon/identify/source.hpp"
#include "daemon/importer/import.hpp"
#include "daemon/record/record_csv.hpp"
#include "daemon/record/run_folder.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/estimation/fit_rows.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/model/record_start.hpp"
#include "ident/signal/intersample.hpp"
#include "ident/validation/output_unit.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::cli {
namespace {

constexpr const char* kSimulateFooter = R"(
INPUT is a file as for `eha fit`; of several columns the one in the model's unit is the input, held between samples,
or straight where the model was estimated so.
V and mV, A and mA are converted; an input in another unit is refused. The output is time_s and the model's output.
A model that comes to rest at a constant input, and whose input_bias was estimated, begins at rest at the first value of
another record's input, any other one as its own record began.
MODEL needs only `transfer_function`; input_map, input_bias, initial_output and units are used if given. Methods:
  exact  exact for a held input; stable models only
  gl1    Grunwald-Letnikov, first order, as in the paper
  cq2    second-order convolution quadrature; stable models only

Examples:
  eha simulate models/fo.json input.csv -o output.csv
  eha simulate models/io.json input.csv --method gl1)";

struct SimulateCommand {
  std::string model_file;
  std::string input_file;
  importer::Options import = {};
  std::optional<std::filesystem::path> output = {};  ///< none: standard output
  ident::SimulationMethod method = ident::SimulationMethod::exact;
  std::optional<ident::Intersample> intersample = {};
  std::optional<double> input_before = {};
};

constexpr std::array kMethods{Choice<ident::SimulationMethod>{"exact", ident::SimulationMethod::exact},
                              Choice<ident::SimulationMethod>{"gl1", ident::SimulationMethod::gl1},
                              Choice<ident::SimulationMethod>{"cq2", ident::SimulationMethod::cq2}};

/// Whether the level before the first row was estimated, as that of the model's own record alone.
bool has_level_of_its_record(const ident::Model& model, const std::string& input_file) {
  return std::any_of(model.parameters.begin(), model.parameters.end(),
                     [&](const ident::ParameterEstimate& p) {
                       return p.role == (model.grey_box ? ident::ParameterRole::initial_state
                                                        : ident::ParameterRole::input_bias) &&
                              !p.fixed;
                     }) &&
         ident::begins_at_a_level(model) && !is_one_record(record_of(model), input_file);
}

/// The model at rest before the input's first row, where it has a level of its own record's there.
/// @throws UsageError  --input-before of a model that has none
ident::Model begun(const ident::Model& model, const SimulateCommand& command, double first, const Console& console) {
  if (command.input_before) {
    if (!ident::begins_at_a_level(model)) {
      throw UsageError(fmt::format(
          "--input-before: {} integrates, has a valve map or a state at the first row, or does not say how long its "
          "record was; leave the option out",
          model.name));
    }
    return ident::begun_at(model, *command.input_before);
  }
  if (!has_level_of_its_record(model, command.input_file)) return model;
  console.info(fmt::format("{} begins at rest at the input's first value, {:.5g} {} (--input-before: at another one)",
                           model.name, first, model.input_unit));
  return ident::begun_at(model, first);
}

/// Warns of a model that its fit rejected, and of an input that is greater than what estimated the model.
void warn_of_doubtful(const ident::Model& model, const SimulateCommand& command, const Eigen::VectorXd& input,
                      const Console& console) {
  if (model.verdict && ident::verdict_word(*model.verdict) == ident::text(ident::Grade::rejected)) {
    console.warning(
        fmt::format("{}: {} is rejected by the fit that made it, so that its output says little of the "
                    "plant; `eha report {}` says why",
                    command.model_file, model.name, shell_word(command.model_file)));
  }
  if (!model.estimation || !model.estimation->input_range) return;
  const auto [lowest, highest] = *model.estimation->input_range;
  const auto [least, greatest] = ident::covered_inputs(*model.estimation->input_range, model.input_map.has_value());
  if (input.minCoeff() >= least && input.maxCoeff() <= greatest) return;
  const std::string unit = ident::after_number(model.input_unit);
  console.warning(fmt::format(
      "{}: the input goes from {:.4g} to {:.4g}{}, and {} was estimated from {:.4g} to {:.4g}{}: beyond that nothing "
      "shows that the plant answers as the model does; record such an input and `eha validate` the model on it",
      command.input_file, input.minCoeff(), input.maxCoeff(), unit, model.name, lowest, highest, unit));
}

/// The output at the input's rows, between which the input is held or straight.
Eigen::VectorXd output_of(const ident::Model& model, const record::InputSeries& input, ident::Intersample intersample,
                          ident::SimulationMethod method) {
  constexpr Eigen::Index kFewest = 4;
  if (intersample == ident::Intersample::held || input.values.size() < kFewest) {
    return ident::simulate(model, input.values, input.step_s, method);
  }
  ident::Record rows;
  rows.step_s = input.step_s;
  rows.input = input.values;
  rows.output = Eigen::VectorXd::Zero(input.values.size());
  const ident::Record fine = ident::in_parts(rows, intersample);
  return ident::simulate(model, fine.input, fine.step_s, method)(Eigen::seq(0, Eigen::last, ident::kPartsOfARow));
}

/// Whether a file, read without an option, has the output of the model's plant too, and did not estimate the model.
bool is_record_for(const ident::Model& model, const std::string& file) {
  if (is_one_record(record_of(model), file)) return false;
  std::error_code ignored;
  if (record::is_run_folder(std::filesystem::absolute(file, ignored).parent_path()))
    return false;  // a run's thinned rows
  try {
    static_cast<void>(identify::in_units_of(identify::load_source(file, {}, {}, {}), model, file));
    return true;
  } catch (const Error&) {
    return false;
  }
}

ExitCode execute(const SimulateCommand& command, Console& console) {
  const ident::Model model =
      in_unit(read_model(command.model_file), console.unit(rig_units_of_model(command.model_file)));
  const importer::ImportedInput imported =
      importer::import_input(command.input_file, command.import, model.input_unit, console.progress_callback());
  console.end_progress();
  print_import(imported.guess, imported.remarks, {}, console);
  const record::InputSeries& input = imported.series;
  warn_of_doubtful(model, command, input.values, console);
  Eigen::VectorXd output;
  try {
    output = output_of(begun(model, command, input.values[0], console), input,
                       intersample_for(command.intersample, model, console), command.method);
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("{}: {}", command.model_file, error.what()));
  } catch (const DataError& error) {
    throw DataError(fmt::format("{}: {}", command.input_file, error.what()));
  }
  if (const auto start = simulated_start(model, 1.0, ident::after_number(model.output_unit))) console.info(*start);
  if (!output.allFinite()) {
    throw DataError(fmt::format("{}: the model's output for {} overflows", command.model_file, command.input_file));
  }
  const ident::Channel channel{"output", model.output_unit};
  const std::string text = record::series_csv(input.time_s, channel, output);
  if (command.output) os::write_file_atomically(*command.output, text);
  if (console.json()) {
    nlohmann::ordered_json document{{"schema", "eha-simulation/1"},    {"model", command.model_file},
                                    {"input", command.input_file},     {"samples", output.size()},
                                    {"step_s", input.step_s},          {"output_min", output.minCoeff()},
                                    {"output_max", output.maxCoeff()}, {"output_last", output[output.size() - 1]},
                                    {"unit", model.output_unit}};
    if (command.output) {
      document["file"] = command.output->string();
    } else {
      document["time_s"] = input.time_s;
      document["output"] = std::vector<double>(output.begin(), output.end());
    }
    console.print_json(document);
  } else if (!command.output) {
    console.print_content(text);
  } else {
    console.print(fmt::format("written: {} ({} samples, {:.6g} .. {:.6g} {})", command.output->string(), output.size(),
                              output.minCoeff(), output.maxCoeff(), model.output_unit));
    console.next_step(
        fmt::format("eha validate {} {}", shell_word(command.model_file),
                    is_record_for(model, command.input_file) ? shell_word(command.input_file) : "RECORD.csv"));
  }
  return ExitCode::ok;
}

}  // namespace

void add_simulate(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("simulate", "Simulate a model's output for an input");
  sub->footer(kSimulateFooter);
  auto& simulate = options_of<SimulateCommand>(*sub, line);
  takes_run_name(sub->add_option("model", simulate.model_file, "Model file (JSON)"), line)
      ->required()
      ->type_name("MODEL");
  sub->add_option("input", simulate.input_file, "File with the input")->required()->type_name("INPUT");
  sub->add_option("-o,--output", simulate.output, "File to write (default: standard output)")->type_name("FILE");
  add_choice(*sub, "--method", simulate.method, kMethods, "How to simulate (default exact)");
  add_intersample_option(*sub, simulate.intersample);
  sub->add_option(
         "--input-before", simulate.input_before,
         "Input before the first row, at which the model is at rest; for a step at the first row (default: the "
         "first row's, of a model whose own level there was estimated)")
      ->type_name("VALUE")
      ->check(finite_number("a finite number", [](double) { return true; }));
  add_import_options(*sub, line, simulate.import, ImportedColumns::input_only);
}

}  // namespace eha::cli
