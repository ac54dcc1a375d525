// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/identify/fit_table.hpp"
#include "daemon/identify/progress.hpp"
#include "daemon/identify/rounds.hpp"
#include "daemon/identify/source.hpp"
#include "ident/acceptance_limits.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/estimation/ladder.hpp"
#include "ident/signal/frequency_response.hpp"
#include "ident/signal/measured_rows.hpp"
#include "ident/validation/first_step.hpp"
#include "ident/validation/loop_in_record.hpp"
#include "ident/validation/recommendation.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::identify {

/// The structures to fit, the record and the options.
struct IdentificationTask {
  const ident::Record& record;
  std::string source_name = {};                          ///< for messages and the models' provenance
  std::string command = {};                              ///< as Source; kept in the models' provenance
  std::string guess = {};                                ///< as Source; kept there, too
  std::string record_sha256 = {};                        ///< as Source
  std::string units = {};                                ///< of lengths in messages, as of Source
  std::vector<ident::StructureOptions> structures = {};  ///< none: the ladder of structures is climbed
  ident::LadderOptions ladder = {};                      ///< requirements on its structures
  ident::FitOptions options = {};
  ident::AcceptanceLimits acceptance = {};
  std::vector<std::string> remarks = {};  ///< on the record, for a person to look at; kept in the models' provenance
  importer::Cut cut = {};                 ///< as Source
  std::string frozen = {};                ///< as Source
  std::string slow_rows = {};             ///< as Source
  std::optional<ident::LoopInRecord> loop = {};  ///< as Source
  std::string gaps = {};                         ///< as Source
  importer::Cut without_gaps = {};               ///< as Source
  std::string against_lost_rows = {};            ///< of a run: what to do where its rows were not measured
  std::string within_dead_band = {};             ///< of identify::within_dead_band()
  std::string at_command_limit = {};             ///< of identify::at_command_limit()
  std::string trend = {};                        ///< the line that was taken out of the output, see without_trend()
  ident::Unmeasured unmeasured = {};             ///< as of Source
  std::size_t repetition_samples = 0;            ///< rows of one repetition; 0 when unknown
  /// Band in which the input moves, from the experiment; none: from its spectrum.
  std::optional<ident::FrequencyInterval> excited = {};
  /// Noise of a compared output sample, see ident::measured_noise() [output unit]; none if nothing repeats.
  std::optional<double> noise_std = {};
  bool lacks_periods = false;                                 ///< as RecordFacts
  std::optional<ident::RecordFacts::Piece> piece = {};        ///< of a record that is too short, as in RecordFacts
  bool is_split_given = false;                                ///< by the user; else identify() may choose another one
  bool judging_part_rests = false;                            ///< as in ident::Verdict; the split is 1 then
  ident::Intersample intersample = ident::Intersample::held;  ///< how `record` was made
  std::filesystem::path models_folder = {};  ///< where the models of a record will be written; empty: nowhere
};

/// Returns the task of a source's own experiment. Without an experiment it has the defaults and no structures.
[[nodiscard]] IdentificationTask task_of(const Source& source);

/// The same task, every field of it, on another record, which must outlive the returned one.
[[nodiscard]] IdentificationTask with_record(const IdentificationTask& task, const ident::Record& record);

/// A fitted model with its verdict.
struct IdentifiedModel {
  ident::StructureOptions structure;
  ident::FitResult result;  ///< its model has a verdict and the duration of the fit
};

/// One structure estimated on one repetition, scored on each.
struct CrossValidatedModel {
  std::string name;
  std::size_t estimated_on = 0;                  ///< repetition, from 0
  std::vector<ident::Score> scores;              ///< one a repetition, offset kept; its own among them
  std::vector<ident::Score> offset_reestimated;  ///< the same, initial_output refitted to each
};

/// Everything that was identified from one record.
struct Identification {
  std::vector<IdentifiedModel> models;
  ident::Recommendation recommendation = {};  ///< of one of the models
  ident::WorkByStage work = {};               ///< of all rounds, dropped fits included
  std::vector<IdentifiedModel> paper = {};    ///< by the paper's procedure, for comparison
  std::optional<ident::FrequencyResponse> frequency_response = {};
  std::vector<std::string> response_notes = {};  ///< what it leaves out and why, one sentence each
  std::vector<CrossValidatedModel> cross_validation = {};
  FitTable fit_table = {};                   ///< of `models`
  FitTable paper_fit_table = {};             ///< of `paper`
  std::vector<std::string> warnings = {};    ///< reasons for missing comparisons, one sentence each
  std::vector<std::string> notes = {};       ///< reasons for a missing frequency response
  std::vector<ident::Refusal> refused = {};  ///< structures that the record does not allow
  std::vector<Round> rounds = {};            ///< in their order, at least one
  /// Where the input column is wrong, the options of `eha fit` that mend it; may be empty.
  std::string mended_input = {};
  std::optional<NextExperiment> next_experiment = {};  ///< set without a model that this record accepts and can judge
};

/// Fits a task, as identify() does in rounds.
using FitTask = std::function<Identification(const IdentificationTask& task)>;

/// The model that is recommended; null without one. Valid as long as the models stand.
[[nodiscard]] const IdentifiedModel* recommended_model(const Identification& identification);

/// The comparisons to make with the task's models.
struct Comparisons {
  enum class Paper { leave_out, include } paper = Paper::leave_out;
  enum class CrossValidation { leave_out, include } cross_validation = CrossValidation::leave_out;
  /// Whether to climb the ladder if the models that the task names fail.
  enum class Ladder { leave_out, include } ladder = Ladder::leave_out;
};

/// Fits and judges each structure of the task, or climbs the ladder if it has none, and recommends a model. Estimates
/// on the whole record where the part that would judge rests (ident::judging_part_rests), and on more than the default
/// share where that does not tell a valve's map (ident::covering_split) and the user gave none. While no
/// model is accepted, tries other starts, then the ladder, and finally writes the next experiment; see Round. Then
/// makes the comparisons and measures the frequency response of the source.
/// @param source  the one whose record the task has
/// @throws DataError, ConfigError  as ident::fit; a DataError begins with the source's name
/// @throws DataError, UsageError   as cross_validate()
[[nodiscard]] Identification identify(const Source& source, const IdentificationTask& task,
                                      const Comparisons& comparisons, const Progress& progress);

/// Fits the task's structures that the paper also has, by the paper's procedure. Leaves out a model to which the
/// procedure does not apply, with the reason in `warnings`. Empty if the task itself uses that procedure.
[[nodiscard]] std::vector<IdentifiedModel> fit_as_in_the_paper(IdentificationTask task,
                                                               std::vector<std::string>& warnings);

/// Returns the recommended one of the task's models; see ident::recommend().
[[nodiscard]] ident::Recommendation recommend(const std::vector<IdentifiedModel>& models,
                                              const IdentificationTask& task);

[[nodiscard]] bool is_accepted(const IdentifiedModel& identified);

/// As ident::next_step(), of its models and recommendation.
[[nodiscard]] ident::NextStep next_step_of(const Identification& identification);

/// ok with at least one accepted model, else model_rejected, else (none converged) not_converged.
[[nodiscard]] ExitCode exit_code(const std::vector<IdentifiedModel>& models);

}  // namespace eha::identify
