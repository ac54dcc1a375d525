// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "daemon/importer/importer_options.hpp"

// The command that asked for a record, as a refusal or a remark gives it back: with everything that was typed, and what
// it lacked.

namespace eha::importer {

/// The command that asked, by default `eha import FILE`, with further options at its end, in place of the same ones
/// before. Of a command that takes none of them: an import into a copy, then the command on the copy.
/// @param extra  such as "--input 2"
[[nodiscard]] std::string command_with(const Options& options, const std::filesystem::path& path,
                                       const std::string& extra);

/// The command without some of its options that have a value, however often.
[[nodiscard]] std::string command_without(const Options& options, const std::vector<std::string>& names);

/// The command without an option that has no value.
[[nodiscard]] std::string command_without_flag(const Options& options, const std::string& name);

/// The command less the options that say where it writes and what it shows: what it reads and makes of it.
[[nodiscard]] std::string command_that_made(const Options& options);

/// The options that do not hold for a file of other columns, of another dialect, and of both and a time column.
inline const std::vector<std::string> kOfColumns{"--time", "--input", "--output"};
inline const std::vector<std::string> kOfText{"--delimiter", "--decimal", "--thousands"};
inline const std::vector<std::string> kOfReading{"--time",    "--input",     "--output", "--delimiter",
                                                 "--decimal", "--thousands", "--period"};

/// The command that asked, on a file that another program has made of the one named.
/// @param made   a name, not yet quoted
/// @param wrong  options that do not hold for that file
/// @param extra  further options, as of command_with(); may be empty
[[nodiscard]] std::string command_on(const Options& options, const std::filesystem::path& path, const std::string& made,
                                     const std::vector<std::string>& wrong = {}, const std::string& extra = {});

/// The options of a command that say how it reads its record, " --decimal comma --resample"; empty without one. Quoted
/// anew: the command may be of a model file that somebody else wrote.
[[nodiscard]] std::string words_of_reading(const std::string& command);

/// A record for a command that takes no such options.
struct ReadAlike {
  std::string import;  ///< "eha import r.csv --resample -o r-record.csv && "; empty: the file is read as it is
  std::string name;    ///< of the file, or of the copy, not yet quoted
};

/// The record of a file as a command read it. @param taken  a name that another copy gets
[[nodiscard]] ReadAlike read_alike(const std::string& command, const std::filesystem::path& path,
                                   const std::string& taken = {});

}  // namespace eha::importer
