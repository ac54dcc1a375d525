// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/identification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <system_error>
#include <utility>

#include "core/os/files.hpp"
#include "daemon/eha/cross_validation.hpp"
#include "daemon/eha/executor.hpp"
#include "daemon/eha/frequency_table.hpp"
#include "daemon/record/run_folder.hpp"
#include "ident/estimation/paper_procedure.hpp"
#include "ident/model/model_file.hpp"
#include "ident/uncertainty/information.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kQuicklyCompared_rows = 1'000'000;

bool accepted(const IdentifiedModel& identified) {
  return identified.result.model.verdict && identified.result.model.verdict->accepted;
}

IdentifiedModel identify_one(const IdentificationTask& task, const ident::StructureOptions& structure) {
  const auto begin = std::chrono::steady_clock::now();
  IdentifiedModel identified{structure, ident::fit(task.record, structure, task.options, thread_executor())};
  ident::Model& model = identified.result.model;
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  if (model.estimation) model.estimation->seconds = taken.count();
  model.verdict = ident::judge(model, task.acceptance, task.interpolated_percent);
  model.provenance["record"] = task.source_name;
  model.provenance["seed"] = fmt::format("{}", task.options.seed);
  model.provenance["decimation"] = fmt::format("{}", task.options.decimation);
  model.provenance["discard_s"] = fmt::format("{}", task.options.discard_s);
  model.provenance["split"] = fmt::format("{}", task.options.split);
  model.provenance["software"] = fmt::format("eha {}", EHA_VERSION);
  return identified;
}

/// One model: the content of its file.
nlohmann::ordered_json to_json(const IdentifiedModel& identified) {
  return nlohmann::ordered_json::parse(ident::to_text(identified.result.model));
}

nlohmann::ordered_json list_of(const std::vector<IdentifiedModel>& models) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const IdentifiedModel& identified : models) list.push_back(to_json(identified));
  return list;
}

/// One line of the manifest's list.
nlohmann::ordered_json summary(const IdentifiedModel& identified, const fs::path& file) {
  const ident::Model& model = identified.result.model;
  nlohmann::ordered_json entry{
      {"name", model.name}, {"file", file.generic_string()}, {"accepted", accepted(identified)}};
  if (model.verdict) entry["reasons"] = model.verdict->reasons;
  if (model.estimation) {
    entry["estimation_r2_percent"] = model.estimation->score.r2_percent;
    entry["seconds"] = model.estimation->seconds;
  }
  if (model.validation) {
    entry["validation_r2_percent"] = model.validation->score.r2_percent;
    if (model.validation->offset_reestimated) {
      entry["validation_r2_percent_offset_reestimated"] = model.validation->offset_reestimated->r2_percent;
    }
  }
  return entry;
}

}  // namespace

std::optional<std::string> size_reservation(std::size_t rows, int decimation) {
  const std::size_t compared = rows / static_cast<std::size_t>(std::max(1, decimation));
  if (compared <= kQuicklyCompared_rows) return std::nullopt;
  return fmt::format(
      "{} rows are to be compared, which may take minutes; --decimate {} compares filtered "
      "samples of them and is nearly as exact for a plant that is slow beside the sampling",
      compared, (rows + kQuicklyCompared_rows - 1) / kQuicklyCompared_rows);
}

std::vector<IdentifiedModel> identify(const IdentificationTask& task, Console& console) {
  if (const auto sentence =
          size_reservation(static_cast<std::size_t>(task.record.input.size()), task.options.decimation)) {
    console.warning(*sentence);
  }
  std::vector<IdentifiedModel> models;
  const double count = static_cast<double>(task.structures.size());
  for (const ident::StructureOptions& structure : task.structures) {
    console.progress(static_cast<double>(models.size()) / count, fmt::format("fitting {}", structure.name));
    try {
      models.push_back(identify_one(task, structure));
    } catch (const DataError& error) {
      throw DataError(fmt::format("{}: {}", task.source_name, error.what()));
    }
  }
  console.end_progress();
  std::vector<ident::Model*> comparable;
  for (IdentifiedModel& identified : models) comparable.push_back(&identified.result.model);
  ident::compare_on_equal_terms(comparable);
  return models;
}

std::vector<IdentifiedModel> identify_as_in_the_paper(IdentificationTask task, Console& console) {
  if (task.options.procedure == ident::Procedure::paper) return {};
  task.options.procedure = ident::Procedure::paper;
  std::vector<IdentifiedModel> models;
  for (const ident::StructureOptions& structure : task.structures) {
    const auto published = ident::published_structure(structure.structure);
    if (!published) continue;
    ident::StructureOptions plain;
    plain.name = structure.name;
    plain.structure = *published;
    try {
      models.push_back(identify_one(task, plain));
    } catch (const Error& error) {
      console.warning(fmt::format("no comparison with the paper's procedure for {}: {}", structure.name, error.what()));
    }
  }
  return models;
}

ExitCode exit_code(const std::vector<IdentifiedModel>& models) {
  if (std::any_of(models.begin(), models.end(), accepted)) return ExitCode::ok;
  const bool converged = std::any_of(models.begin(), models.end(), [](const IdentifiedModel& identified) {
    return identified.result.model.estimation && identified.result.model.estimation->converged;
  });
  return converged ? ExitCode::model_rejected : ExitCode::not_converged;
}

std::vector<fs::path> write_models(const std::vector<IdentifiedModel>& models, const fs::path& folder) {
  os::create_folders(folder);
  std::vector<fs::path> written;
  for (const IdentifiedModel& identified : models) {
    written.push_back(folder / (identified.result.model.name + ".json"));
    os::write_file_atomically(written.back(), ident::to_text(identified.result.model));
  }
  return written;
}

std::vector<fs::path> publish_models(const fs::path& run_folder, const std::vector<IdentifiedModel>& models,
                                     const std::vector<IdentifiedModel>& paper) {
  const fs::path models_folder = run_folder / record::kModelsFolder;
  const fs::path rejected_folder = models_folder / "rejected";
  std::vector<fs::path> written;
  nlohmann::ordered_json entries = nlohmann::ordered_json::array();
  for (const IdentifiedModel& identified : models) {
    const std::string file = identified.result.model.name + ".json";
    const bool good = accepted(identified);
    const fs::path path = (good ? models_folder : rejected_folder) / file;
    os::create_folders(path.parent_path());
    os::write_file_atomically(path, ident::to_text(identified.result.model));
    // An earlier fit may have judged otherwise; one model has one verdict.
    std::error_code ignored;
    fs::remove((good ? rejected_folder : models_folder) / file, ignored);
    entries.push_back(summary(identified, fs::relative(path, run_folder)));
    written.push_back(path);
  }
  const bool any = std::any_of(models.begin(), models.end(), accepted);
  record::finish_manifest(run_folder, {{"accepted", any}, {"models", entries}, {"paper_procedure", list_of(paper)}});
  if (any) record::publish_latest(run_folder);
  return written;
}

void show(const Identification& identification, nlohmann::ordered_json document, Console& console) {
  document["models"] = list_of(identification.models);
  document["paper_procedure"] = list_of(identification.paper);
  if (identification.frequency_response) {
    document["frequency_response"] = frequency_json(*identification.frequency_response, identification.models);
  }
  if (!identification.cross_validation.empty()) {
    document["cross_validation"] = cross_validation_json(identification.cross_validation);
  }
  document["files"] = nlohmann::ordered_json::array();
  for (const fs::path& path : identification.written) document["files"].push_back(path.string());
  document["exit_code"] = static_cast<int>(exit_code(identification.models));
  console.print_json(document);
  console.print(report(identification.models, identification.paper));
  if (identification.frequency_response) {
    console.print(frequency_table(*identification.frequency_response, identification.models));
  }
  if (!identification.cross_validation.empty()) {
    console.print(cross_validation_table(identification.cross_validation));
  }
  for (const fs::path& path : identification.written) console.print(fmt::format("written: {}", path.string()));
}

}  // namespace eha::cli
