// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "daemon/eha/console.hpp"
#include "daemon/importer/options.hpp"

namespace eha::cli {

/// Which of the options on a file's columns a command takes.
enum class ImportedColumns { record, input_only };

/// Adds --time, --input, --output, --delimiter, --decimal, --period, --from, --to and --resample.
void add_import_options(CLI::App& app, importer::Options& options, ImportedColumns columns);

/// Prints the guesses about a file and the corrections to it.
void print_import(const std::string& guess, const std::vector<std::string>& repairs, const Console& console);

}  // namespace eha::cli
