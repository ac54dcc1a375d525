// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "daemon/eha/console.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/signal/frequency_response.hpp"

namespace eha::cli {

/// What is sought in which record.
struct IdentificationTask {
  const ident::Record& record;
  std::string source_name = {};  ///< for messages and the models' provenance
  std::vector<ident::StructureOptions> structures = {};
  ident::FitOptions options = {};
  ident::AcceptanceLimits acceptance = {};
  double interpolated_percent = 0.0;  ///< of the record's rows [%]
};

/// A fitted and judged model.
struct IdentifiedModel {
  ident::StructureOptions structure;
  ident::FitResult result;  ///< its model has a verdict, and the seconds that it took
};

/// A sentence for the user when comparing that many rows may take minutes (ten million took six).
[[nodiscard]] std::optional<std::string> size_reservation(std::size_t rows, int decimation);

/// Fits and judges each structure, in order.
/// @throws DataError, ConfigError  as ident::fit, the source's name put in front of a DataError
[[nodiscard]] std::vector<IdentifiedModel> identify(const IdentificationTask& task, Console& console);

/// What the paper's procedure gives on the same record, for comparison: the paper's two structures among the task's.
/// Where it cannot be applied a warning says why and the model is left out. Empty when the task is itself by that
/// procedure.
[[nodiscard]] std::vector<IdentifiedModel> identify_as_in_the_paper(IdentificationTask task, Console& console);

/// ok with at least one accepted model, else model_rejected, else (none converged) not_converged.
[[nodiscard]] ExitCode exit_code(const std::vector<IdentifiedModel>& models);

/// One structure estimated on one repetition, scored on each.
struct CrossValidatedModel {
  std::string name;
  std::size_t estimated_on = 0;                  ///< repetition, from 0
  std::vector<ident::Score> scores;              ///< one a repetition, offset kept; its own among them
  std::vector<ident::Score> offset_reestimated;  ///< the same, initial_output fitted anew on each
};

/// What an identification came to: a model and its verdict for each structure, the paper's beside them, what the record
/// says without a model, files written.
struct Identification {
  std::vector<IdentifiedModel> models;
  std::vector<IdentifiedModel> paper;
  std::optional<ident::FrequencyResponse> frequency_response = {};
  std::vector<CrossValidatedModel> cross_validation = {};  ///< empty unless asked for
  std::vector<std::filesystem::path> written = {};
};

/// Puts an identification on standard output, as a table or as the rest of `document`.
/// @param document  for --json: what the command has to say besides `models`, `paper_procedure`, `frequency_response`,
///                  `cross_validation`, `files`, `exit_code`
void show(const Identification& identification, nlohmann::ordered_json document, Console& console);

/// The table of models, the notes beneath it, and each model's formula.
/// @param paper  rows for comparison, marked `paper`
[[nodiscard]] std::string report(const std::vector<IdentifiedModel>& models, const std::vector<IdentifiedModel>& paper);

/// Writes DIR/<name>.json for each model, whole or not at all. @returns the paths @throws IoError, PermissionError
std::vector<std::filesystem::path> write_models(const std::vector<IdentifiedModel>& models,
                                                const std::filesystem::path& folder);

/// Publishes the models of a run: accepted ones to models/, the others to models/rejected/, the manifest's section
/// `identification`, then the link `latest` if one was accepted.
/// @returns the paths written @throws IoError, PermissionError, DataError
std::vector<std::filesystem::path> publish_models(const std::filesystem::path& run_folder,
                                                  const std::vector<IdentifiedModel>& models,
                                                  const std::vector<IdentifiedModel>& paper);

}  // namespace eha::cli
