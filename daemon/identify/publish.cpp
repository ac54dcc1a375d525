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

bool is_folder_or_missing(const fs::path& path) {
  std::error_code ignored;
  const fs::file_type type = fs::symlink_status(path, ignored).type();
  return type == fs::file_type::directory || type == fs::file_type::not_found;
}

enum class Came { accepted, rejected };

/// The folders of a run's models, held open: whoever owns the run could put a link in their place at any time, and
/// their files have names of his choice.
class ModelFolders {
 public:
  /// @throws PermissionError  one of them is a link
  ModelFolders(const record::OpenRun& run, const std::vector<IdentifiedModel>& models)
      : accepted_path_(run.path() / record::kModelsFolder) {
    const bool has_rejected = !std::all_of(models.begin(), models.end(), is_accepted);
    const fs::path folder = run.files() / record::kModelsFolder;
    try {
      accepted_ = os::open_folder(folder);
      const fs::path rejected = os::path_through(accepted_) / record::kRejectedFolder;
      std::error_code ignored;
      const bool is_there = fs::exists(fs::symlink_status(rejected, ignored));
      if (has_rejected || is_there) rejected_ = os::open_folder(rejected);
    } catch (const IoError&) {
      if (is_folder_or_missing(folder) && is_folder_or_missing(folder / record::kRejectedFolder)) throw;
      throw PermissionError(
          fmt::format("{}: it, or its folder {}, is a link or no folder, and models are written into no folder that "
                      "somebody else may have chosen; remove it",
                      accepted_path_.string(), record::kRejectedFolder));
    }
  }

  /// Writes a model's file, and removes that of an earlier fit with the other verdict. @returns its path
  [[nodiscard]] fs::path write(const ident::Model& model, Came came) const {
    const std::string file = model.name + ".json";
    const bool is_accepted = came == Came::accepted;
    const os::FileDescriptor& other = is_accepted ? rejected_ : accepted_;
    os::write_file_atomically(os::path_through(is_accepted ? accepted_ : rejected_) / file, ident::to_text(model));
    std::error_code ignored;
    if (other) fs::remove(os::path_through(other) / file, ignored);
    return (is_accepted ? accepted_path_ : accepted_path_ / record::kRejectedFolder) / file;
  }

 private:
  fs::path accepted_path_;
  os::FileDescriptor accepted_;
  os::FileDescriptor rejected_;  ///< none: no model is rejected, and none was before
};

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

std::vector<fs::path> publish(const Identification& identification, const record::OpenRun& run) {
  const ModelFolders folders(run, identification.models);
  record::IdentificationEntry entry{
      .models = {}, .recommendation = identification.recommendation, .paper_procedure = to_json(identification.paper)};
  std::vector<fs::path> written;
  for (const IdentifiedModel& identified : identification.models) {
    const bool accepted = is_accepted(identified);
    const fs::path path = folders.write(identified.result.model, accepted ? Came::accepted : Came::rejected);
    entry.accepted = entry.accepted || accepted;
    entry.models.push_back(manifest_entry(identified, path.lexically_relative(run.path())));
    written.push_back(path);
  }
  // Written before the manifest, which lists every file of the folder.
  std::vector<fs::path> tables;
  write_tables(identification, run.files(), tables);
  for (const fs::path& table : tables) written.push_back(run.path() / table.filename());
  if (const auto next = write_next_experiment(identification, run.files())) {
    written.push_back(run.path() / next->filename());
    entry.other["next_experiment"] = {{"file", next->filename().string()},
                                      {"reason", identification.next_experiment->reason}};
  }
  entry.other["rounds"] = to_json(identification.rounds);
  if (!identification.refused.empty()) entry.other["refused"] = to_json(identification.refused);
  if (!identification.response_notes.empty()) {
    entry.other["frequency_response_notes"] = identification.response_notes;
  }
  std::string against = record::reason_against_latest(record::read_manifest(run.files()));
  if (against.empty()) against = record::what_stands_for_latest(run);
  const bool is_latest = entry.accepted && against.empty();
  if (entry.accepted && !is_latest) entry.other["not_latest"] = against;
  record::write_identification(run.files(), std::move(entry));
  if (is_latest) record::publish_latest(run);
  return written;
}

}  // namespace eha::identify
