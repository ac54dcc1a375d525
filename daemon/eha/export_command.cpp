// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "config/controller_config.hpp"
#include "config/rig_config.hpp"
#include "core/capitalised.hpp"
#include "core/code_text.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/eha/axis_table.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/controller_argument.hpp"
#include "daemon/eha/exported_origin.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/eha/run_argument.hpp"
#include "daemon/identify/judging.hpp"
#include "daemon/identify/source.hpp"
#include "daemon/record/record_export.hpp"
#include "daemon/record/run_folder.hpp"
#include "ident/export/controller_formats.hpp"
#include "ident/export/model_formats.hpp"
#include "ident/model/model_file.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/model/record_start.hpp"
#include "ident/validation/output_unit.hpp"

namespace eha::cli {
namespace {

struct ExportCommand {
  std::string source;                                 ///< model file, run folder or record
  std::string format;                                 ///< of ident::model_formats() or record::record_formats()
  std::optional<ident::FrequencyInterval> band = {};  ///< none: the model's own
  std::optional<std::filesystem::path> output = {};   ///< none: standard output
  std::string as_given = {};                          ///< the line, quoted for a shell
};

/// Writes the text of a function, not over what no export has written. @throws UsageError
void write_text(const std::filesystem::path& path, const std::string& text) {
  constexpr std::array<std::string_view, 8> kData{".csv", ".tsv", ".dat", ".mat", ".h5", ".hdf5", ".toml", ".xlsx"};
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored) &&
      std::find(kData.begin(), kData.end(), path.extension()) != kData.end()) {
    throw UsageError(fmt::format("-o {}: a file of data is there, which a function would replace; name another file",
                                 path.string()));
  }
  os::write_file_atomically(path, text);
}

/// Octave and MATLAB call a function by its file's name, which then has to be one. @throws UsageError
void require_callable(const ExportCommand& command, const std::string& function) {
  constexpr std::array<std::string_view, 3> kByFile{"octave", "matlab", "simulink"};
  if (!command.output || std::find(kByFile.begin(), kByFile.end(), command.format) == kByFile.end()) return;
  if (command.output->stem() == function) return;
  const std::string other = (command.output->parent_path() / (function + ".m")).string();
  throw UsageError(
      fmt::format("-o {}: Octave and MATLAB call a function by the name of its file, which may have letters, digits "
                  "and _ and begins with a letter: -o {}",
                  command.output->string(), shell_word(other)));
}

std::string export_footer() {
  std::string text = "\nFormats of a model:\n";
  for (const ident::ModelFormat& format : ident::model_formats())
    text += fmt::format("  {:<7} {}\n", format.name, format.what);
  text += "Formats of a controller:\n";
  for (const ident::ControllerFormat& format : ident::controller_formats())
    text += fmt::format("  {:<8} {}\n", format.name, format.what);
  text += "  csv      model, valve, controller and promise as a table\n";
  text += "Formats of a run or another record:\n";
  for (const record::RecordFormat& format : record::record_formats()) {
    text += fmt::format("  {:<7} {}\n", format.name, format.what);
  }
  return text + R"(
A model's function takes the input [input unit], one value a row, and the rows' distance [s], and gives the output; bias
or valve map, offset and the states at the first row are included. Octave, MATLAB: y = NAME(u, step_s). Python:
NAME(u, step_s). C: NAME_init(&model, step_s), then y = NAME_step(&model, u) for each row. NAME is the file's, else eha_ and
the model's; for Octave and MATLAB the file's name has to be that of a function; the arguments' names end in their units (u_V). Whole orders are exact for a held input. Fractional orders are replaced by a stable rational function at most
1 % and 1 degree off over the band; the file states the error measured. Without -o the text goes to standard output.

Examples:
  eha export models/io.json --format octave -o eha_io.m
  eha export models/fo.json --format c --band 0.02:5 -o eha_fo.c
  eha export runs/latest --format mat -o run.mat)";
}

template <typename Format>
const Format* named(std::span<const Format> formats, const std::string& name) {
  const auto found = std::find_if(formats.begin(), formats.end(), [&](const Format& f) { return f.name == name; });
  return found == formats.end() ? nullptr : &*found;
}

bool is_folder(const std::string& source) {
  std::error_code ignored;
  return std::filesystem::is_directory(source, ignored);
}

ExitCode export_model(const ExportCommand& given, const ident::ModelFormat& format, Console& console) {
  ExportCommand command = given;
  if (is_folder(command.source)) {
    const auto model = record::is_run_folder(command.source) ? recommended_model(command.source) : std::nullopt;
    if (!model) {
      throw UsageError(fmt::format(
          "{} is no run that recommends a model, which --format {} exports; name one of {}/*.json", command.source,
          format.name, is_folder(command.source + "/models") ? command.source + "/models" : command.source));
    }
    command.source = model->string();
  }
  if (format.is_binary && !command.output) {
    throw UsageError(fmt::format("--format {} needs a file: -o NAME.{}", format.name, format.name));
  }
  const ident::Model model = in_unit(read_model(command.source), console.unit(rig_units_of_model(command.source)));
  ident::ExportedModel exported;
  try {
    exported = ident::exported(model, command.band);
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("{}: {}", command.source, error.what()));
  }
  exported.origin.push_back(file_line(command.source));
  const bool is_straight = identify::intersample_of(model) == ident::Intersample::straight;
  if (is_straight) {
    constexpr std::string_view kHeld =
        "its input was straight between the rows that estimated it, and the export holds it: step it far finer than "
        "those rows";
    exported.origin.push_back(capitalised(std::string(kHeld)) + ".");
    console.warning(fmt::format(
        "{}: {}, with the inputs between them, or it errs more than the model; `eha simulate` takes the input as "
        "straight",
        command.source, kHeld));
  }
  if (!exported.rejected_for.empty()) {
    console.warning(
        fmt::format("{}: the model is {}: {}", command.source, exported.verdict, exported.rejected_for.front()));
  }
  // Octave and MATLAB call a function by its file's name.
  const std::string function = identifier(command.output ? command.output->stem().string() : "eha_" + model.name);
  require_callable(command, function);
  if (command.output && format.name == "python" && function == "io") {
    console.warning(
        "Python has a module io of its own, which `import io` gives; choose another file name: -o eha_io.py");
  }
  const std::string text = format.text(exported, function);
  if (command.output) write_text(*command.output, text);
  if (console.json()) {
    nlohmann::ordered_json document{{"schema", "eha-export-result/1"},
                                    {"source", command.source},
                                    {"format", format.name},
                                    {"name", function},
                                    {"notes", ident::notes(exported)}};
    if (command.output) {
      document["file"] = command.output->string();
    } else {
      document["text"] = text;
    }
    console.print_json(document);
  } else if (!command.output) {
    console.print_content(text);
  } else {
    const std::string accuracy = exported.error
                                     ? fmt::format("within {} % and {} degrees from {:.4g} to {:.4g} Hz",
                                                   ident::figure_text(exported.error->gain_percent),
                                                   ident::figure_text(exported.error->phase_deg),
                                                   exported.error->band.lowest_Hz, exported.error->band.highest_Hz)
                                     : "exact for a held input";
    console.print(fmt::format("written: {} ({}, {} states, {})", command.output->string(), function,
                              ident::state_space(exported.sections).b.size(), accuracy));
    // The code begins at rest at v = 0; `eha simulate` would begin at the input's first value.
    const std::string before =
        ident::begins_at_a_level(model) ? fmt::format(" --input-before={:.10g}", 0.0 - model.input_bias) : "";
    // Of a part of a record its rest at the start is none of the model's.
    const auto command_of_fit = model.provenance.find("command");
    const bool is_part =
        command_of_fit != model.provenance.end() && command_of_fit->second.find(" --from ") != std::string::npos;
    const auto input = is_part ? std::nullopt : input_words_of_record(record_of(model), model.input_unit);
    console.next_step(fmt::format("eha simulate {} {}{} -o {}", shell_word(command.source), input.value_or("INPUT.csv"),
                                  before, shell_word(free_name("output.csv"))));
  }
  return ExitCode::ok;
}

ExitCode export_table(const ExportCommand& command, const config::ControllerConfig& controller, Console& console) {
  const std::string text =
      axis_table({.controller = controller, .model = model_of(controller), .sheet = sheet_of(controller)},
                 console.unit(rig_units_of_controller(controller)));
  if (!command.output) {
    console.print_content(text);
    return ExitCode::ok;
  }
  os::write_file_atomically(*command.output, text);
  console.print_json({{"schema", "eha-export-result/1"},
                      {"source", command.source},
                      {"format", command.format},
                      {"file", command.output->string()}});
  console.print(fmt::format("written: {}", command.output->string()));
  console.next_step(suggest::track(access_of_controller(command.source, controller), command.source));
  return ExitCode::ok;
}

ExitCode export_controller(const ExportCommand& command, Console& console) {
  if (command.format == "csv") return export_table(command, config::load_controller(command.source), console);
  const auto* format = named(ident::controller_formats(), command.format);
  if (format == nullptr) {
    std::string names;
    for (const ident::ControllerFormat& f : ident::controller_formats()) names += std::string(f.name) + ", ";
    names += "csv";
    throw UsageError(
        fmt::format("{} is a controller; --format: expected one of {}, got {}", command.source, names, command.format));
  }
  const config::ControllerConfig controller = config::load_controller(command.source);
  const DisplayUnit unit = console.unit(rig_units_of_controller(controller));
  ident::ExportedController exported{
      .coefficients = ident::coefficients(ident::in_length_unit(controller.settings, unit.factor("in"))),
      .notes = {},
      .length_unit = unit.of("in")};
  exported.notes = ident::controller_notes(exported.coefficients, controller.name, exported.length_unit);
  for (const std::string& line : origin_lines(command.source, controller, unit)) exported.notes.push_back(line);
  std::string function = identifier(command.output ? command.output->stem().string() : "eha_" + controller.name);
  if ((command.format == "octave" || command.format == "simulink") && function == "axis") {
    console.warning(
        "axis is a function of Octave and MATLAB, which this file would hide; another name: -o axis_control.m");
  }
  require_callable(command, function);
  // The texts format their own numbers.
  for (const auto& [name, value] : ident::controller_numbers(exported.coefficients)) {
    if (function == name) function += "_controller";
  }
  const std::string text = format->text(exported, function);
  if (command.output) write_text(*command.output, text);
  if (console.json()) {
    nlohmann::ordered_json document{{"schema", "eha-export-result/1"},
                                    {"source", command.source},
                                    {"format", format->name},
                                    {"name", function},
                                    {"notes", exported.notes}};
    document[command.output ? "file" : "text"] = command.output ? command.output->string() : text;
    console.print_json(document);
  } else if (!command.output) {
    console.print_content(text);
  } else {
    console.print(fmt::format("written: {} ({}, call it every {:g} s)", command.output->string(), function,
                              controller.settings.tick_s));
    console.next_step(suggest::track(access_of_controller(command.source, controller), command.source));
  }
  return ExitCode::ok;
}

/// To twelve digits: 3 in are 76.2 mm, not 76.19999999999999 mm.
double without_rounding(double value) {
  if (value == 0.0 || !std::isfinite(value)) return value;
  const double scale = std::pow(10.0, 11.0 - std::floor(std::log10(std::abs(value))));
  return std::round(value * scale) / scale;
}

ExitCode export_record(const ExportCommand& command, const record::RecordFormat& format, Console& console) {
  const bool to_file = command.output.has_value();
  if (!to_file && (format.name != "csv" || console.json())) {
    throw UsageError(fmt::format("--format {} needs a file: -o NAME{}", format.name, format.ending));
  }
  identify::Source source =
      identify::load_source(command.source, {}, {.then = command.as_given}, console.progress_callback());
  console.end_progress();
  // A file for programs keeps the record's unit, unless another one was asked for.
  const DisplayUnit unit = console.unit();
  for (auto [values, channel] : {std::pair(&source.record.input, &source.record.input_channel),
                                 std::pair(&source.record.output, &source.record.output_channel)}) {
    const double factor = unit.factor(channel->unit);
    if (factor != 1.0) *values = (factor * *values).unaryExpr(&without_rounding);
    channel->unit = unit.of(channel->unit);
  }
  for (const std::string& warning : identify::warnings(source)) console.warning(warning);
  if (!to_file) {
    record::write_record_csv(source.record, [&](std::string_view text) { console.print_content(text); });
    return ExitCode::ok;
  }
  format.write(source.record, *command.output);
  console.print_json({{"schema", "eha-export-result/1"},
                      {"source", command.source},
                      {"format", format.name},
                      {"rows", source.record.input.size()},
                      {"sample_period_s", source.record.step_s},
                      {"file", command.output->string()}});
  console.print(fmt::format("written: {} ({} rows, {:g} s apart)", command.output->string(), source.record.input.size(),
                            source.record.step_s));
  console.next_step(
      fmt::format("eha fit {} -o {}", shell_word(command.output->string()), shell_word(free_name("models"))));
  return ExitCode::ok;
}

ExitCode execute(const ExportCommand& command, Console& console) {
  if (is_controller_file(command.source)) return export_controller(command, console);
  if (const auto* format = named(ident::model_formats(), command.format))
    return export_model(command, *format, console);
  if (const auto* format = named(record::record_formats(), command.format))
    return export_record(command, *format, console);
  throw UsageError(fmt::format("--format {} is for controllers, as `eha tune` writes them; {} is none", command.format,
                               command.source));
}

}  // namespace

void add_export(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand(
      "export", "Write a model or a controller for another program, or a record as CSV, MAT or HDF5");
  sub->footer(export_footer());
  auto& command = options_of<ExportCommand>(*sub, line);
  command.as_given = line.as_given;
  takes_run_name(sub->add_option("source", command.source, "Model file, controller file, run folder or record"), line)
      ->required()
      ->type_name("MODEL|CONTROLLER|RECORD|RUN");
  std::vector<std::string> names;
  for (const ident::ModelFormat& format : ident::model_formats()) names.emplace_back(format.name);
  for (const record::RecordFormat& format : record::record_formats()) names.emplace_back(format.name);
  for (const ident::ControllerFormat& format : ident::controller_formats()) {
    if (std::find(names.begin(), names.end(), format.name) == names.end()) names.emplace_back(format.name);
  }
  sub->add_option("--format", command.format, "Form of the file")
      ->required()
      ->type_name(fmt::format("{}", fmt::join(names, "|")))
      ->check(CLI::IsMember(names).description(""));
  sub->add_option_function<std::string>(
         "--band", [&command](const std::string& text) { command.band = band_of(text); },
         "Frequencies over which fractional orders are approximated [Hz] (default: the model's usable band)")
      ->type_name("LOW:HIGH");
  sub->add_option("-o,--output", command.output, "File to write")->type_name("FILE");
}

}  // namespace eha::cli
