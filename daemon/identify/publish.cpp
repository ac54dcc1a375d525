// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/publish.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/identify/frequency_comparison.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_summary.hpp"
#include "ident/model/model_file.hpp"

namespace eha::identify {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

record::ModelEntry manifest_entry(const IdentifiedModel& identified, const fs::path& file) {
  const ident::Model& model = identified.result.model;
  record::ModelEntry entry{
      .name = model.name, .file = file.generic_string(), .accepted = is_accepted(identified), .reasons = {}};
  if (model.verdict) {
    entry.grade = ident::text(model.verdict->grade);
    entry.reasons = model.verdict->reasons;
    if (const auto& band = model.verdict->usable_band) {
      entry.usable_band_Hz = {band->lowest_Hz, band->highest_Hz};
    }
  }
  if (model.estimation) {
    entry.estimation_r2_percent = model.estimation->score.r2_percent;
    entry.seconds = model.estimation->seconds;
  }
  if (model.validation) {
    entry.validation_r2_percent = model.validation->score.r2_percent;
    if (model.validation->offset_reestimated) {
      entry.validation_r2_percent_offset_reestimated = model.validation->offset_reestimated->r2_percent;
    }
  }
  return entry;
}

/// @returns the path; nothing if there is none to write, after removing an earlier one
std::optional<fs::path> write_next_experiment(const Identification& identification, const fs::path& folder) {
  const fs::path file = folder / kNextExperimentFile;
  if (!identification.next_experiment) {
    std::error_code ignored;
    fs::remove(file, ignored);
    return {};
  }
  os::write_file_atomically(file, identification.next_experiment->text);
  return file;
}

/// Writes the tables of the fit and the frequency response, if there are any.
void write_tables(const Identification& identification, const fs::path& folder, std::vector<fs::path>& written) {
  for (const auto& [table, name] :
       {std::pair(&identification.fit_table, kFitFile), std::pair(&identification.paper_fit_table, kPaperFitFile)}) {
    const fs::path path = folder / name;
    std::error_code ignored;
    if (table->models.empty()) {
      fs::remove(path, ignored);  // an earlier fit's
    } else {
      os::write_file_atomically(path, to_csv(*table));
      written.push_back(path);
    }
  }
  if (identification.frequency_response) {
    written.push_back(write_frequency_response(*identification.frequency_response, identification.models, folder));
  }
}

}  // namespace

Json to_json(const std::vector<ident::Refusal>& refused) {
  Json list = Json::array();
  for (const ident::Refusal& refusal : refused) list.push_back({{"model", refusal.model}, {"reason", refusal.reason}});
  return list;
}

Json to_json(const ident::WorkByStage& stages) {
  Json object = Json::object();
  const auto counts = [](const ident::Work& work) -> Json {
    return {{"global_searches", work.global_searches},
            {"local_searches", work.local_searches},
            {"evaluations", work.evaluations},
            {"jacobians", work.jacobians},
            {"transforms", work.transforms}};
  };
  for (const auto& [stage, work] : stages) object[stage] = counts(work);
  object["total"] = counts(total(stages));
  return object;
}

Json to_json(const std::vector<Round>& rounds) {
  Json list = Json::array();
  for (const Round& round : rounds) {
    list.push_back({{"what", round.what}, {"reason", round.reason}, {"accepted", round.accepted}});
  }
  return list;
}

std::optional<fs::path> next_experiment_file(const std::vector<fs::path>& written) {
  const auto is_it = [](const fs::path& path) { return path.filename() == kNextExperimentFile; };
  const auto found = std::find_if(written.begin(), written.end(), is_it);
  return found == written.end() ? std::nullopt : std::optional(*found);
}

Json to_json(const IdentifiedModel& identified) { return Json::parse(ident::to_text(identified.result.model)); }

Json to_json(const std::vector<IdentifiedModel>& models) {
  Json list = Json::array();
  for (const IdentifiedModel& identified : models) list.push_back(to_json(identified));
  return list;
}

std::vector<fs::path> write_models(const Identification& identification, const fs::path& folder) {
  os::create_folders(folder);
  std::vector<fs::path> written;
  for (const IdentifiedModel& identified : identification.models) {
    written.push_back(folder / (identified.result.model.name + ".json"));
    os::write_file_atomically(written.back(), ident::to_text(identified.result.model));
  }
  write_tables(identification, folder, written);
  if (const auto next = write_next_experiment(identification, folder)) written.push_back(*next);
  return written;
}

std::vector<fs::path> publish(const Identification& identification, const fs::path& run_folder) {
  const fs::path models_folder = run_folder / record::kModelsFolder;
  const fs::path rejected_folder = models_folder / record::kRejectedFolder;
  for (const fs::path& folder : {models_folder, rejected_folder}) {
    std::error_code ignored;
    if (fs::is_symlink(fs::symlink_status(folder, ignored))) {
      throw PermissionError(
          fmt::format("{}: is a link, and models are written into no folder that somebody else may "
                      "have chosen; remove it",
                      folder.string()));
    }
  }
  record::IdentificationEntry entry{
      .models = {}, .recommendation = identification.recommendation, .paper_procedure = to_json(identification.paper)};
  std::vector<fs::path> written;
  for (const IdentifiedModel& identified : identification.models) {
    const std::string file = identified.result.model.name + ".json";
    const bool accepted = is_accepted(identified);
    const fs::path path = (accepted ? models_folder : rejected_folder) / file;
    os::create_folders(path.parent_path());
    os::write_file_atomically(path, ident::to_text(identified.result.model));
    // An earlier fit may have had the other verdict; only one file of a model may exist.
    std::error_code ignored;
    fs::remove((accepted ? rejected_folder : models_folder) / file, ignored);
    entry.accepted = entry.accepted || accepted;
    entry.models.push_back(manifest_entry(identified, fs::relative(path, run_folder)));
    written.push_back(path);
  }
  // Written before the manifest, which lists every file of the folder.
  write_tables(identification, run_folder, written);
  if (const auto next = write_next_experiment(identification, run_folder)) {
    written.push_back(*next);
    entry.other["next_experiment"] = {{"file", next->filename().string()},
                                      {"reason", identification.next_experiment->reason}};
  }
  entry.other["rounds"] = to_json(identification.rounds);
  if (!identification.refused.empty()) entry.other["refused"] = to_json(identification.refused);
  if (!identification.response_notes.empty()) {
    entry.other["frequency_response_notes"] = identification.response_notes;
  }
  std::string against = record::reason_against_latest(record::read_manifest(run_folder));
  if (against.empty()) against = record::what_stands_for_latest(run_folder);
  const bool is_latest = entry.accepted && against.empty();
  if (entry.accepted && !is_latest) entry.other["not_latest"] = against;
  record::write_identification(run_folder, std::move(entry));
  if (is_latest) record::publish_latest(run_folder);
  return written;
}

}  // namespace eha::identify
