// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/importer/importer_options.hpp"
#include "daemon/importer/output_findings.hpp"
#include "daemon/record/record_csv.hpp"
#include "ident/record.hpp"

// Records from files of other programs: delimited text, MAT-files, HDF5; see eha-record(5). Missing facts are guessed,
// and the guess is reported. If two guesses are equally good, the file is refused with a command that chooses. Every
// function throws
//   DataError        the content is wrong or ambiguous: "FILE:LINE: what, what was expected", and the command to go on
//   UsageError       an option does not suit the file
//   PermissionError  the file may not be read
//   IoError          it is missing, a directory, or the disk failed
// HDF5 and matio are not thread-safe: one thread at a time.

namespace eha::importer {

/// A record, and how it was read from a file.
struct Imported {
  ident::Record record;
  std::vector<std::size_t> held = {};  ///< of record.unmeasured, the rows whose input was not measured
  std::string guess = {};  ///< what was guessed, in one line; empty for a record as eha-record(5) describes it
  std::vector<std::string> remarks =
      {};                       ///< for a person to look at: exchanged columns, a sensor at its end; a sentence each
  std::string exchange = {};    ///< "--input 3 --output 2": the options that exchange input and output
  Cut cut = {};                 ///< what the remarks on the output ask to keep
  std::string frozen = {};      ///< where the sensor froze, as OutputFindings
  std::string slow_rows = {};   ///< that the rows are too slow for the plant, as in the remarks; mostly empty
  Cut without_gaps = {};        ///< the longest part without a gap that was filled
  std::string gaps = {};        ///< where such gaps are, "from 42 to 42.29 s"; empty without one
  bool is_closed_loop = false;  ///< a set point stood beside input and output
  std::vector<std::string> repairs = {};  ///< gaps and jitter that --resample mended, one sentence each
  /// Of rows that were moved to an even grid, and of which none is missing: the same rows as if they had been sampled
  /// evenly, as --period reads them. None of more than a million rows.
  std::optional<ident::Record> as_even = {};
};

/// Reads a record. Ten million rows of text (0.26 GB) take about 4 s and 0.4 GB on one core.
[[nodiscard]] Imported import_record(const std::filesystem::path& path, const Options& options,
                                     const Progress& progress = {});

/// An input to simulate a model with, and how it was read, as in Imported.
struct ImportedInput {
  record::InputSeries series;
  std::string guess = {};
  std::vector<std::string> remarks = {};
};

/// Reads an input. @param unit  of the model's input, to which the values are converted: of several columns the one in
/// it is taken; empty: any
/// @throws DataError  also when the input is in a unit of another kind
[[nodiscard]] ImportedInput import_input(const std::filesystem::path& path, const Options& options,
                                         const std::string& unit, const Progress& progress = {});

/// Hands over a record as CSV text as eha-record(5) describes it, in pieces of about 1 MB; with filled rows, a last
/// column `filled` is 1 there. Numbers read back to the same bits. Cost O(N), 27 bytes a row.
void write_record_csv(const Imported& imported, const std::function<void(std::string_view)>& write,
                      const Progress& progress = {});

}  // namespace eha::importer
