// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <string>

#include "core/os/files.hpp"
#include "daemon/eha/commands.hpp"
#include "daemon/eha/import_options.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/importer/import.hpp"
#include "daemon/record/record_csv.hpp"
#include "ident/estimation/fit.hpp"

namespace eha::cli {

ExitCode execute(const SimulateCommand& command, Console& console) {
  const ident::Model model = read_model(command.model_file);
  const importer::ImportedInput imported =
      importer::import_input(command.input_file, command.import, model.input_unit, console.progress_callback());
  console.end_progress();
  print_import(imported.guess, {}, console);
  const record::InputSeries& input = imported.series;
  Eigen::VectorXd output;
  try {
    output = ident::simulate(model, input.values, input.step_s, command.method);
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("{}: {}", command.model_file, error.what()));
  } catch (const DataError& error) {
    throw DataError(fmt::format("{}: {}", command.input_file, error.what()));
  }
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
    console.next_step(fmt::format("eha validate {} RECORD.csv", command.model_file));
  }
  return ExitCode::ok;
}

}  // namespace eha::cli
