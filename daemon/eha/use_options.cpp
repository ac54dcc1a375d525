// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/use_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/record/record_export.hpp"
#include "ident/export/model_formats.hpp"

namespace eha::cli {
namespace {

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

std::optional<double> number(const std::string& text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

ident::FrequencyInterval band_of(const std::string& text) {
  const std::size_t colon = text.find(':');
  const auto low = number(text.substr(0, colon));
  const auto high = colon == std::string::npos ? std::nullopt : number(text.substr(colon + 1));
  if (!low || !high || !(*low > 0.0 && *low < *high && *high / *low <= 1e8)) {
    throw CLI::ValidationError("--band", "expected LOW:HIGH in Hz with 0 < LOW < HIGH, got " + text);
  }
  return {*low, *high};
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

}  // namespace eha::cli
