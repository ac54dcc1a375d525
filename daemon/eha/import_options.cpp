// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/import_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <string_view>

#include "core/unit_names.hpp"
#include "daemon/eha/option_values.hpp"

namespace eha::cli {
namespace {

constexpr std::array kDelimiters{Choice<char>{"comma", ','}, Choice<char>{"semicolon", ';'}, Choice<char>{"tab", '\t'},
                                 Choice<char>{"blank", ' '}, Choice<char>{"bar", '|'},       Choice<char>{",", ','},
                                 Choice<char>{";", ';'}};
constexpr std::array kDecimals{Choice<char>{"point", '.'}, Choice<char>{"comma", ','}, Choice<char>{".", '.'},
                               Choice<char>{",", ','}};
constexpr std::array kThousands{Choice<char>{"comma", ','}, Choice<char>{"point", '.'},
                                Choice<char>{"apostrophe", '\''}};
/// Sentences about gaps that are printed without -v.
constexpr std::size_t kRepairsShown = 20;

}  // namespace

void add_import_options(CLI::App& app, const ParsedLine& line, importer::Options& options, ImportedColumns columns) {
  // A refusal gives the command that goes on: what was typed, with options behind it, of which the last counts.
  options.command = line.as_given;
  const std::string group = "Files of other programs (each of these replaces a guess)";
  const auto column = [&](const char* name, std::optional<std::string>& target, const char* what) {
    app.add_option(name, target, fmt::format("Column of {}: name, struct.field, or number from 1", what))
        ->type_name("COLUMN")
        ->take_last()
        ->group(group);
  };
  column("--time", options.time, "the time");
  column("--input", options.input, "the input");
  if (columns == ImportedColumns::record) column("--output", options.output, "the output");
  add_choice(app, "--delimiter", options.delimiter, kDelimiters, "What separates columns")->group(group);
  add_choice(app, "--decimal", options.decimal, kDecimals, "The decimal sign")->group(group);
  add_choice(app, "--thousands", options.thousands, kThousands, "What separates thousands")->group(group);
  app.add_option("--period", options.period_s, "The sample period; replaces the time column")
      ->type_name("SECONDS")
      ->check(finite_number("seconds above 0", [](double s) { return s > 0.0; }))
      ->take_last()
      ->group(group);
  const auto any = finite_number("seconds", [](double) { return true; });
  app.add_option("--from", options.from_s, "Leave out rows before this time")
      ->type_name("SECONDS")
      ->check(any)
      ->take_last()
      ->group(group);
  app.add_option("--to", options.to_s, "Leave out rows after this time")
      ->type_name("SECONDS")
      ->check(any)
      ->take_last()
      ->group(group);
  const CLI::Validator is_unit(
      [](std::string& text) {
        const auto known = known_unit(text);
        if (known) text = *known;
        return known ? std::string() : text + ": expected a unit such as V, mV, mA, mm, in, bar or %";
      },
      "");
  const auto unit = [&](const char* name, std::optional<std::string>& target, const char* what) {
    app.add_option(name, target,
                   fmt::format("Unit of the {}, such as {}; for a file that has none, or a wrong one", what,
                               std::string_view(what) == "input" ? "V" : "mm"))
        ->type_name("UNIT")
        ->check(is_unit)
        ->take_last()
        ->group(group);
  };
  unit("--input-unit", options.input_unit, "input");
  if (columns == ImportedColumns::record) unit("--output-unit", options.output_unit, "output");
  if (columns == ImportedColumns::record) {
    app.add_option("--input-late", options.input_late,
                   "Rows by which the input's column comes late against the output: each row gets the input of so many "
                   "rows later (default 0)")
        ->type_name("ROWS")
        ->check(CLI::Range(std::size_t{0}, std::size_t{1'000'000}).description(""))
        ->take_last()
        ->group(group);
  }
  app.add_flag("--resample", options.resample, "Fill gaps and missing values, and even out the times of the rows")
      ->group(group);
  app.add_flag("--keep-lone-rows", options.keep_lone_rows,
               "Take rows far from both their neighbours as measured, and no loose contact")
      ->group(group);
}

void print_import(const std::string& guess, const std::vector<std::string>& remarks,
                  const std::vector<std::string>& repairs, const Console& console) {
  if (!guess.empty()) console.info(guess);
  for (const std::string& remark : remarks) console.warning(remark);
  for (std::size_t i = 0; i < repairs.size(); ++i) {
    if (i < kRepairsShown) {
      console.info(repairs[i]);
    } else {
      console.debug(repairs[i]);
    }
  }
  if (repairs.size() > kRepairsShown) {
    console.info(fmt::format("and {} more of these; -v lists them all", repairs.size() - kRepairsShown));
  }
}

}  // namespace eha::cli
