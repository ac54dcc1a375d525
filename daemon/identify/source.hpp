// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/experiment_config.hpp"
#include "daemon/importer/importer_options.hpp"
#include "daemon/importer/output_findings.hpp"
#include "daemon/record/run_folder.hpp"
#include "ident/record.hpp"
#include "ident/signal/intersample.hpp"
#include "ident/signal/measured_rows.hpp"
#include "ident/validation/loop_in_record.hpp"

namespace eha::identify {

/// A record to identify from, and its origin.
struct Source {
  std::string name;  ///< as given on the command line, for messages
  ident::Record record;
  std::optional<config::ExperimentConfig> experiment;  ///< the run's, or the named one
  std::optional<std::filesystem::path> run_folder;     ///< when it is a run
  record::OpenRun opened = {};                         ///< the same, held; what is written of it goes there
  /// Rows of one repetition, of the run or as the named experiment would play it; 0 when unknown.
  std::size_t repetition_samples = 0;
  acquisition::Outcome outcome = acquisition::Outcome::completed;
  std::string sha256 =
      {};  ///< of a file that is fitted; empty: not computed, or of a run, whose run.json has those of its files
  std::string units = {};                        ///< of displayed lengths, from the run's rig file; empty: none
  ident::Unmeasured unmeasured = {};             ///< of the rows of the run or file
  std::string guess = {};                        ///< of a file: the guesses, in one line; may be empty
  std::string command = {};                      ///< of importer::command_that_made(); empty: of no command line
  std::vector<std::string> remarks = {};         ///< on the record: for a person to look at, one sentence each
  std::string rig_text = {};                     ///< of a run: the rig file as used; for config::parse_rig
  bool is_of_run = false;                        ///< a file in a run's folder, whose input is known
  bool is_closed_loop = false;                   ///< of a file: by its columns, as a set point beside input and output
  std::string exchange = {};                     ///< of a file: the options that exchange input and output
  importer::Cut cut = {};                        ///< of a file: the part that the remarks on its output ask to keep
  std::string frozen = {};                       ///< of a file: where the sensor froze, as importer::Imported
  std::string slow_rows = {};                    ///< of a file: that its rows are too slow for the plant, the same
  std::optional<ident::LoopInRecord> loop = {};  ///< of a file in closed loop
  importer::Cut without_gaps = {};               ///< of a file: the longest part without a filled gap
  std::string gaps = {};                         ///< of a file: where gaps were filled, as importer::Imported
  std::vector<std::string> repairs = {};         ///< of a file: repaired gaps and jitter, one sentence each
  std::optional<ident::Record> as_even = {};     ///< of a file whose rows were moved, as importer::Imported
  /// What the input does between rows. If it is straight, the record has ident::kPartsOfARow rows for each of the
  /// file's.
  ident::Intersample intersample = ident::Intersample::held;
};

/// Takes the input of a file for straight between its rows.
/// @throws UsageError  the source is a run, whose input is held
/// @throws DataError   fewer than four rows
void take_input_as_straight(Source& source);

/// Length of what a run that ended early was to record [s]; none for a completed run, and for a file.
[[nodiscard]] std::optional<double> planned_s(const Source& source);

/// Returns reasons why models of this source are less reliable: an incomplete run, rows that were not measured. One
/// sentence each.
[[nodiscard]] std::vector<std::string> warnings(const Source& source);

/// Of several sources, all that is to be said of them: remarks and warnings, each with its source's name.
[[nodiscard]] std::vector<std::string> named_warnings(const std::vector<Source>& sources);

/// Reads a run folder, or a record from a file of any kind that the importer knows.
/// @param experiment_file  replaces the run's own experiment
/// @param options          of the import of a file; a run takes from_s and to_s, times of its record
/// @throws DataError, IoError, PermissionError, ConfigError  as record::read_run, import_record, load_experiment
/// @throws UsageError      as import_record; or import options were given for a run
[[nodiscard]] Source load_source(const std::string& name, const std::optional<std::string>& experiment_file,
                                 const importer::Options& options = {}, const importer::Progress& progress = {});

}  // namespace eha::identify
