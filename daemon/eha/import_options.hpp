// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "daemon/eha/command_line.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/importer/importer_options.hpp"

namespace CLI {
class App;
}

namespace eha::cli {

/// Selects the options on a file's columns that a command takes.
enum class ImportedColumns { record, input_only };

/// Adds the options of core/reading_options.hpp, for a record or for an input alone.
void add_import_options(CLI::App& app, const ParsedLine& line, importer::Options& options, ImportedColumns columns);

/// Prints what was guessed of a file, warns of its remarks and prints its corrections.
void print_import(const std::string& guess, const std::vector<std::string>& remarks,
                  const std::vector<std::string>& repairs, const Console& console);

}  // namespace eha::cli
