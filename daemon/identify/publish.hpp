// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "daemon/identify/identification.hpp"
#include "daemon/record/open_run.hpp"

namespace eha::identify {

/// Returns a model in the form of its file.
[[nodiscard]] nlohmann::ordered_json to_json(const IdentifiedModel& identified);
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<IdentifiedModel>& models);

[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<ident::Refusal>& refused);
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<Round>& rounds);
[[nodiscard]] nlohmann::ordered_json to_json(const ident::WorkByStage& stages);

/// Writes DIR/<name>.json for each model; fit.csv, fit_paper.csv, the frequency response and the next experiment go to
/// the same folder.
/// @returns the paths, the models' first @throws IoError, PermissionError
[[nodiscard]] std::vector<std::filesystem::path> write_models(const Identification& identification,
                                                              const std::filesystem::path& folder);

/// Publishes an identification in the run's folder, which is held open: accepted models go to models/, the others to
/// models/rejected/; fit.csv, fit_paper.csv, the frequency response, the next experiment and the manifest's section
/// `identification` follow; then the link `latest` moves to the run if a model was accepted.
/// @returns the paths, the models' first @throws IoError, PermissionError, DataError
[[nodiscard]] std::vector<std::filesystem::path> publish(const Identification& identification,
                                                         const record::OpenRun& run);

/// Returns the next experiment among the files written; none if the identification wrote none.
[[nodiscard]] std::optional<std::filesystem::path> next_experiment_file(
    const std::vector<std::filesystem::path>& written);

}  // namespace eha::identify
