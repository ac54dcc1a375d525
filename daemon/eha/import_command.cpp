// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <system_error>

#include "core/display_unit.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/import_options.hpp"
#include "daemon/importer/import.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kImportFooter = R"(
Reads a record of another program and writes it as CSV with the columns time_s, input, output; see eha-record(5).
FILE is text (commas, semicolons, tabs, bars or blanks; decimal point or comma; UTF-8, UTF-16, Latin-1; any line ends;
with a header, with a row of units, or without), a MAT-file (version 4, 5, 7.3: arrays, structs of arrays) or HDF5.
Missing facts are guessed, and the guess is printed in one line. An ambiguous file is refused; the message lists its
columns and a command that chooses. "74,973" may be 74973 or 74.973: --thousands comma or --decimal comma says which.
--resample fills gaps and lists each of them; filled rows are marked in a column `filled` and count for nothing in a fit.

Examples:
  eha import bench.csv -o record.csv
  eha import bench.mat --time rec.t --input rec.u --output rec.y -o record.csv
  eha import logger.txt --delimiter tab --decimal comma --from 2 --to 60 --resample -o record.csv)";

struct ImportCommand {
  std::string file;
  importer::Options import = {};
  std::optional<std::filesystem::path> output = {};  ///< none: standard output
};

Json channel_json(const ident::Channel& channel, const Eigen::VectorXd& values) {
  return {{"name", channel.name}, {"unit", channel.unit}, {"min", values.minCoeff()}, {"max", values.maxCoeff()}};
}

Json document_for(const ImportCommand& command, const importer::Imported& imported) {
  const ident::Record& record = imported.record;
  Json document{{"schema", "eha-import/1"},
                {"source", command.file},
                {"guess", imported.guess},
                {"remarks", imported.remarks},
                {"rows", record.input.size()},
                {"start_s", record.start_s},
                {"step_s", record.step_s},
                {"input", channel_json(record.input_channel, record.input)},
                {"output", channel_json(record.output_channel, record.output)},
                {"filled_rows", imported.record.unmeasured.size()},
                {"repairs", imported.repairs}};
  if (command.output) document["file"] = command.output->string();
  return document;
}

std::string range_text(const ident::Channel& channel, const Eigen::VectorXd& values, const DisplayUnit& unit) {
  const double factor = unit.factor(channel.unit);
  return fmt::format("{} {:.4g} .. {:.4g} {}", channel.name, factor * values.minCoeff(), factor * values.maxCoeff(),
                     unit.of(channel.unit));
}

ExitCode execute(const ImportCommand& command, Console& console) {
  if (record::is_run_folder(command.file)) {
    throw UsageError(fmt::format("{}: a run, which needs no import; `eha fit {}` reads it as it is", command.file,
                                 shell_word(command.file)));
  }
  const importer::Imported imported =
      importer::import_record(command.file, command.import, console.progress_callback());
  console.end_progress();
  print_import(imported.guess, imported.remarks, imported.repairs, console);
  if (!imported.record.unmeasured.empty()) {
    console.warning(
        fmt::format("{} of {} rows were not measured and are filled; they are marked in the column `filled`",
                    imported.record.unmeasured.size(), imported.record.input.size()));
  }
  console.print_json(document_for(command, imported));
  if (!command.output) {
    if (!console.json()) {
      importer::write_record_csv(imported, [&](std::string_view piece) { console.print_content(piece); });
    }
    return ExitCode::ok;
  }
  os::AtomicFile file(*command.output);
  importer::write_record_csv(
      imported, [&](std::string_view piece) { file.write(piece); }, console.progress_callback());
  file.commit();
  console.end_progress();
  const ident::Record& record = imported.record;
  const DisplayUnit unit = console.unit();
  console.print(fmt::format("written: {}\n{} rows, {}, {}", command.output->string(), record.input.size(),
                            range_text(record.input_channel, record.input, unit),
                            range_text(record.output_channel, record.output, unit)));
  const importer::Cut& part = imported.without_gaps;
  console.next_step("eha fit " + shell_word(command.output->string()) +
                    (part.keeps_all() ? std::string() : " " + importer::cut_options(part)));
  return ExitCode::ok;
}

}  // namespace

void add_import(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("import", "Read a record of another program and write it as CSV");
  sub->footer(kImportFooter);
  auto& import = options_of<ImportCommand>(*sub, line);
  sub->add_option("file", import.file, "Text, MAT-file or HDF5")->required()->type_name("FILE");
  sub->add_option("-o", import.output, "CSV file to write (default: standard output)")->type_name("FILE");
  add_import_options(*sub, line, import.import, ImportedColumns::record);
}

}  // namespace eha::cli
