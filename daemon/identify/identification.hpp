// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
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
#include "ident/validation/recommendation.hpp"

namespace eha::identify {

/// The structures to fit, the record and the options.
struct IdentificationTask {
  const ident::Record& record;
  std::string source_name = {};                          ///< for messages and the models' provenance
  std::vector<ident::StructureOptions> structures = {};  ///< none: the ladder of structures is climbed
  ident::LadderOptions ladder = {};                      ///< what is wanted of its structures
  ident::FitOptions options = {};
  ident::AcceptanceLimits acceptance = {};
  double interpolated_percent = 0.0;   ///< of the record's rows [%]
  std::size_t repetition_samples = 0;  ///< rows of one repetition; 0 when unknown
  /// Where the input moves, as the experiment says; none: its spectrum decides.
  std::optional<ident::FrequencyInterval> excited = {};
  /// Noise of a compared output sample, see ident::measured_noise() [output unit]; none where nothing repeats.
  std::optional<double> noise_std = {};
  bool lacks_periods = false;  ///< as RecordFacts
};

/// The task that a source's own experiment sets. Without an experiment it has the defaults and no structures.
[[nodiscard]] IdentificationTask task_of(const Source& source);

/// A fitted and judged model.
struct IdentifiedModel {
  ident::StructureOptions structure;
  ident::FitResult result;  ///< its model has a verdict, and the seconds that it took
};

/// One structure estimated on one repetition, scored on each.
struct CrossValidatedModel {
  std::string name;
  std::size_t estimated_on = 0;                  ///< repetition, from 0
  std::vector<ident::Score> scores;              ///< one a repetition, offset kept; its own among them
  std::vector<ident::Score> offset_reestimated;  ///< the same, initial_output fitted anew on each
};

/// Everything that was identified from one record.
struct Identification {
  std::vector<IdentifiedModel> models;
  ident::Recommendation recommendation = {};  ///< of one of the models
  ident::WorkByStage work = {};               ///< of all rounds, fits that were dropped included
  std::vector<IdentifiedModel> paper = {};    ///< by the paper's procedure, for comparison
  std::optional<ident::FrequencyResponse> frequency_response = {};
  std::vector<std::string> response_notes = {};  ///< what it leaves out and why, one sentence each
  std::vector<CrossValidatedModel> cross_validation = {};
  FitTable fit_table = {};                             ///< of `models`
  FitTable paper_fit_table = {};                       ///< of `paper`
  std::vector<std::string> warnings = {};              ///< reasons for missing comparisons, one sentence each
  std::vector<std::string> notes = {};                 ///< reasons for a missing frequency response
  std::vector<ident::Refusal> refused = {};            ///< structures that the record does not allow
  std::vector<Round> rounds = {};                      ///< in their order, at least one
  std::optional<NextExperiment> next_experiment = {};  ///< where the rounds ended without an accepted model
};

/// The comparisons to make with the task's models.
struct Comparisons {
  enum class Paper { leave_out, include } paper = Paper::leave_out;
  enum class CrossValidation { leave_out, include } cross_validation = CrossValidation::leave_out;
  /// Whether the ladder is climbed when the models that the task names fail.
  enum class Ladder { leave_out, include } ladder = Ladder::leave_out;
};

/// A warning when comparing this many rows may take minutes (ten million took six); otherwise nothing.
[[nodiscard]] std::optional<std::string> size_warning(std::size_t rows, int decimation);

/// Fits and judges each structure of the task, or climbs the ladder where it has none, and recommends a model. While no
/// model is accepted it tries other starts, then the ladder, and at last makes the next experiment; see Round. Then
/// makes the comparisons and measures the frequency response of the source.
/// @param source  the one whose record the task has
/// @throws DataError, ConfigError  as ident::fit, the source's name put in front of a DataError
/// @throws DataError, UsageError   as cross_validate()
[[nodiscard]] Identification identify(const Source& source, const IdentificationTask& task,
                                      const Comparisons& comparisons, const Progress& progress);

/// Fits the task's structures that the paper also has, by the paper's procedure. A model to which the procedure does
/// not apply is left out, and `warnings` gives the reason. Empty when the task itself uses that procedure.
[[nodiscard]] std::vector<IdentifiedModel> fit_as_in_the_paper(IdentificationTask task,
                                                               std::vector<std::string>& warnings);

/// The one of the task's models to take; see ident::recommend().
[[nodiscard]] ident::Recommendation recommend(const std::vector<IdentifiedModel>& models,
                                              const IdentificationTask& task);

[[nodiscard]] bool is_accepted(const IdentifiedModel& identified);

/// ok with at least one accepted model, else model_rejected, else (none converged) not_converged.
[[nodiscard]] ExitCode exit_code(const std::vector<IdentifiedModel>& models);

}  // namespace eha::identify
