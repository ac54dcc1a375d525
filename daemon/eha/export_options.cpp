// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/export_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/record/record_export.hpp"
#include "ident/export/model_formats.hpp"

namespace eha::cli {
namespace {

constexpr const char* kCompareFooter = R"(
Runs (or other records): fits one integer-order model behind a valve map to each, on the same samples with the same
criteria. Shows the changes from the first run to each other one with joint intervals: at most 1 % false alarms for all
parameters and runs together.
Models and one record: scores each model on the record and fits its structure to it (refit). A model is of another plant,
whatever its R2, if its parameters differ from the refit's and its error is more than 1.5 times the refit's.
Models alone: compares their parameters.
-o FILE.html writes a before/after report: what changed, both records and errors over time, Bode plots over one another;
.svg, .png or .pdf draws the Bode plots alone.

Examples:
  eha compare runs/20261122T101500Z-paper runs/latest -o changes.html
  eha compare models/io.json models/fo.json record.csv -o bode.svg)";

constexpr const char* kReplayFooter = R"(
Plays a record's voltages [V] through the simulated rig and scores it against the measured displacement [in, mm], from the
record's first position. --calibrate fits keys of [sim] in eha-rig(5) to the record and writes the rig file of the twin.
KEY=LOW:HIGH sets bounds (default a fifth to five times the rig file's value). Each value has a 95 % interval. A parameter
that the record does not determine, alone or apart from another one, is refused by name (exit code 10).

Examples:
  eha replay runs/latest -o overlay.svg
  eha replay record.csv --rig sim.toml --calibrate valve_null_offset_V valve_dead_band_V moving_mass_kg=5:60)";

/// Checks that a file's name ends in one of these.
CLI::Validator ends_in(std::vector<std::string> endings) {
  return CLI::Validator(
      [endings = std::move(endings)](std::string& name) {
        const std::string ending = std::filesystem::path(name).extension().string();
        const bool known = std::find(endings.begin(), endings.end(), ending) != endings.end();
        return known ? std::string()
                     : fmt::format("expected a name that ends in {}, got {}", fmt::join(endings, " or "), name);
      },
      "");
}

std::string export_footer() {
  std::string text = "\nFormats of a model:\n";
  for (const ident::ModelFormat& format : ident::model_formats())
    text += fmt::format("  {:<7} {}\n", format.name, format.what);
  text += "Formats of a run or another record:\n";
  for (const record::RecordFormat& format : record::record_formats()) {
    text += fmt::format("  {:<7} {}\n", format.name, format.what);
  }
  return text + R"(
A model's function takes the input [input unit], one value a row, and the rows' distance [s], and gives the output; bias
or valve map, offset and the states at the first row are included. Octave, MATLAB: y = NAME(u, step_s). Python:
NAME(u, step_s). C: NAME_init(&model, step_s), then y = NAME_step(&model, u) for each row. NAME is the file's, else eha_ and
the model's. Whole orders are exact for a held input. Fractional orders are replaced by a stable rational function at most
1 % and 1 degree off over the band; the file states the error measured. Without -o the text goes to standard output.

Examples:
  eha export models/io.json --format octave -o eha_io.m
  eha export models/fo.json --format c --band 0.02:5 -o eha_fo.c
  eha export runs/latest --format mat -o run.mat)";
}

}  // namespace

void add_export(CLI::App& app, ExportCommand& command) {
  CLI::App* sub = app.add_subcommand("export", "Write a model for another program, or a record as CSV, MAT or HDF5");
  sub->footer(export_footer());
  sub->add_option("source", command.source, "Model file, run folder or record")->required()->type_name("MODEL|RUN");
  std::vector<std::string> names;
  for (const ident::ModelFormat& format : ident::model_formats()) names.emplace_back(format.name);
  for (const record::RecordFormat& format : record::record_formats()) names.emplace_back(format.name);
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

void add_compare(CLI::App& app, CompareCommand& command) {
  CLI::App* sub = app.add_subcommand("compare", "Show what changed between runs, or which model suits a record");
  sub->footer(kCompareFooter);
  sub->add_option("sources", command.sources, "Run folders, records or model files (.json)")
      ->required()
      ->expected(2, 1000)
      ->type_name("RUN|MODEL|FILE");
  sub->add_option("-o,--output", command.output,
                  "Report to write (.html), or a picture of the Bode plots (.svg, .png, .pdf)")
      ->type_name("FILE")
      ->check(ends_in({".html", ".svg", ".png", ".pdf"}));
}

void add_replay(CLI::App& app, ReplayCommand& command) {
  CLI::App* sub =
      app.add_subcommand("replay", "Play a record's voltages through the simulated rig, or fit the rig to the record");
  sub->footer(kReplayFooter);
  sub->add_option("source", command.source, "Run folder or record")->required()->type_name("RUN|FILE");
  sub->add_option("--rig", command.rig_file, "Rig file of a simulated rig (default the shipped one)")->type_name("RIG");
  CLI::Option* calibrate = sub->add_option("--calibrate", command.calibrate, "Fit these keys of [sim]; may be repeated")
                               ->type_name("KEY[=LOW:HIGH]");
  sub->add_option("--twin", command.twin, "Rig file to write the calibrated values to (default twin.toml)")
      ->type_name("FILE")
      ->needs(calibrate);
  sub->add_option("-o,--output", command.output, "Overlay to write: a picture (.svg, .png, .pdf) or .csv")
      ->type_name("FILE")
      ->check(ends_in({".svg", ".png", ".pdf", ".csv"}));
}

}  // namespace eha::cli
