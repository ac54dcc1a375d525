// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/subject.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <system_error>
#include <utility>

#include "core/error.hpp"
#include "core/json_text.hpp"
#include "core/os/files.hpp"
#include "core/os/written_at.hpp"
#include "core/shell_word.hpp"
#include "daemon/identify/frequency_comparison.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/own_file.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "daemon/report/figures.hpp"
#include "ident/model/model_file.hpp"
#include "ident/validation/recommendation.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::report {
namespace {

constexpr std::size_t kMostNamed = 3;            // models in a title
constexpr const char* kTrackRows = "track.csv";  // daemon/track writes them
constexpr const char* kTrackFile = "track.json";

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string text_of(const Json& json) { return json.is_string() ? json.get<std::string>() : std::string(); }

ReportedModel read_model(const fs::path& path, const std::string& shown) {
  record::require_no_link_of_others(path);
  return {ident::model_from_text(os::read_file(path), os::shown(path)), shown};
}

/// Reads files that an earlier version or another program's folder may lack.
void read_tables(const fs::path& folder, Subject& subject) {
  std::error_code ignored;
  for (const std::string_view name : {identify::kFitFile, identify::kPaperFitFile, identify::kFrequencyResponseFile}) {
    static_cast<void>(record::listed_file(folder, std::string(name)));
  }
  if (const fs::path path = folder / identify::kFitFile; fs::exists(path, ignored)) {
    subject.fit = identify::read_fit_table(path);
  }
  if (const fs::path path = folder / identify::kPaperFitFile; fs::exists(path, ignored)) {
    subject.paper_fit = identify::read_fit_table(path);
  }
  if (const fs::path path = folder / identify::kFrequencyResponseFile; fs::exists(path, ignored)) {
    subject.response = record::read_number_table(path);
  }
}

/// The rows of a controller's trial; empty where they are none.
identify::FitTable track_table(const fs::path& path) {
  const record::NumberTable rows = record::read_number_table(path);
  const auto* time = rows.find("time_s");
  const auto* reference = rows.find("reference_in");
  const auto* rod = rows.find("displacement_in");
  const auto* command = rows.find("command_V");
  if (time == nullptr || reference == nullptr || rod == nullptr || command == nullptr) return {};
  return {.input = {"command", "V"},
          .output = {"displacement", "in"},
          .time_s = *time,
          .applied = *command,
          .measured = *rod,
          .models = {{"reference", *reference}}};
}

/// What a trial that ended early showed of the valve; empty where the file does not say.
void read_ended_trial(const fs::path& path, Subject& subject) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return;
  const Json document = parse_json_text<Json>(os::read_file(path));
  if (!document.is_object() || !document.value("ended_early", false)) return;
  for (const Json& change : document.value("changes", Json::array())) {
    if (change.is_string()) subject.trial_changes.push_back(change.get<std::string>());
  }
  const auto leak = document.find("leak");
  if (leak != document.end() && leak->is_object()) {
    subject.leak = ident::Leak{leak->value("creep_in_per_s", 0.0), leak->value("as_V", 0.0)};
  }
  const auto stood = document.find("stood");
  if (stood != document.end()) subject.trial_stood = text_of(*stood);
}

/// Puts the models in the order of every table.
void sort_models(Subject& subject, const ident::Recommendation& chosen) {
  subject.models = ident::in_table_order(
      subject.models, chosen, [](const ReportedModel& reported) -> const ident::Model& { return reported.model; });
  subject.has_recommendation =
      !chosen.model.empty() && !subject.models.empty() && subject.models.front().model.name == chosen.model;
  const bool has_runner_up =
      std::any_of(subject.models.begin(), subject.models.end(),
                  [&](const ReportedModel& reported) { return reported.model.name == chosen.runner_up; });
  if (subject.has_recommendation && has_runner_up) subject.runner_up = chosen.runner_up;
  subject.pictured_models = subject.has_recommendation && !has_runner_up ? 1 : kMostCurves;
}

/// Returns the folder of a model file's tables: its run folder if it is below one, else the folder beside it.
fs::path folder_of_tables(const fs::path& model_file) {
  const fs::path beside = model_file.parent_path();
  for (const fs::path& folder : {beside / "..", beside / ".." / ".."}) {
    if (record::is_run_folder(folder)) return folder;
  }
  return beside;
}

/// The record that a model is of, its hash, and which rows and columns of it; empty where its file does not say.
std::string record_of(const ident::Model& model) {
  std::string text;
  for (const char* key : {"record", "record_sha256", "record_rows", "read_as"}) {
    const auto found = model.provenance.find(key);
    if (found != model.provenance.end()) text += found->second + "\n";
  }
  return text;
}

/// The models of a record in a folder of models; of a run's rejected ones those that were not rejected, too.
std::vector<ReportedModel> models_of_record(const fs::path& folder, const std::string& record) {
  constexpr std::size_t kMostFiles = 500;
  constexpr std::uintmax_t kMostBytes = 16U << 20U;  // none of a model is near it
  std::vector<fs::path> files;
  for (const fs::path& place : folder.filename() == "rejected" ? std::vector<fs::path>{folder, folder.parent_path()}
                                                               : std::vector<fs::path>{folder}) {
    std::error_code ended;
    for (fs::directory_iterator at(place.empty() ? "." : place, ended), end; !ended && at != end; at.increment(ended)) {
      const fs::path name = at->path().filename();
      std::error_code unknown;
      const bool is_file = name.extension() == ".json" && at->is_regular_file(unknown) && !unknown;  // a pipe waits
      if (is_file && at->file_size(unknown) <= kMostBytes && files.size() < kMostFiles) files.push_back(place / name);
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<ReportedModel> found;
  for (const fs::path& file : files) {
    try {
      ReportedModel reported = read_model(file, file.string());
      if (record_of(reported.model) == record) found.push_back(std::move(reported));
    } catch (const Error&) {  // no model, or a file of another user
    }
  }
  return found;
}

/// The recommended one of all models beside the subject's of the same record; none if it is among the subject's, or if
/// their files do not name one record.
std::optional<RecommendedBeside> recommended_beside(const Subject& subject, const fs::path& folder) {
  const std::string record = subject.models.empty() ? std::string() : record_of(subject.models.front().model);
  const auto is_of_record = [&](const ReportedModel& reported) { return record_of(reported.model) == record; };
  if (record.empty() || !std::all_of(subject.models.begin(), subject.models.end(), is_of_record)) return std::nullopt;
  const std::vector<ReportedModel> beside = models_of_record(folder, record);
  std::vector<const ident::Model*> all;
  for (const ReportedModel& reported : beside) all.push_back(&reported.model);
  const std::string best = ident::recommend(all, {}).model;
  const auto is_best = [&](const ReportedModel& reported) { return reported.model.name == best; };
  const auto found = std::find_if(beside.begin(), beside.end(), is_best);
  if (found == beside.end() || std::any_of(subject.models.begin(), subject.models.end(), is_best)) return std::nullopt;
  return RecommendedBeside{
      best, found->model.verdict ? std::string(ident::verdict_word(*found->model.verdict)) : std::string("not judged"),
      found->file};
}

/// The model that the verdict of a named one calls clearly better; empty where it calls none so.
std::string better_than(const Subject& subject, const std::string& name) {
  for (const ReportedModel& reported : subject.models) {
    if (reported.model.name != name || !reported.model.verdict) continue;
    for (const ident::Criterion& criterion : reported.model.verdict->criteria) {
      if (criterion.kind == ident::CriterionKind::above_recommended && has_failed(criterion))
        return criterion.parameter;
    }
  }
  return {};
}

/// " of m_hair_dryer": the folder, or the run, that a model file is in.
std::string folder_text(const fs::path& model_file) {
  std::error_code ignored;
  fs::path folder = fs::absolute(model_file, ignored).parent_path();
  while (folder.filename() == "models" || folder.filename() == "rejected") folder = folder.parent_path();
  return folder.filename().empty() ? std::string() : " of " + folder.filename().string();
}

/// " of bench.csv", the record that all models are of; where they name none or several, their folder.
std::string origin_text(const std::vector<ReportedModel>& models, const fs::path& first_file) {
  std::string record;
  for (const ReportedModel& reported : models) {
    const auto at = reported.model.provenance.find("record");
    if (at == reported.model.provenance.end() || at->second.empty()) return folder_text(first_file);
    if (!record.empty() && record != at->second) return folder_text(first_file);
    record = at->second;
  }
  return " of " + fs::path(record).filename().string();
}

}  // namespace

ident::NextStep Subject::next_step() const {
  std::vector<const ident::Model*> all;
  for (const ReportedModel& reported : models) all.push_back(&reported.model);
  if (all.empty()) return {};
  const ident::Model& first = *all.front();
  return ident::next_step(all, first.verdict && first.verdict->accepted ? first.name : std::string());
}

std::optional<double> Subject::trip_s() const {
  const Json& at_s = part("report", "fault", "at_s");
  return part("outcome") == "faulted" && at_s.is_number() ? std::optional(at_s.get<double>()) : std::nullopt;
}

std::optional<suggest::RigAccess> Subject::access() const {
  if (!manifest) return std::nullopt;
  suggest::RigAccess rig = suggest::access_of_run(*manifest);
  return folder.empty() ? rig : suggest::with_fit_of(std::move(rig), folder);
}

std::optional<double> Subject::split_s() const {
  for (const ReportedModel* reported : pictured()) {
    if (fit.find(reported->model.name) == nullptr) continue;
    const std::size_t estimating = reported->model.estimation ? reported->model.estimation->score.samples : 0;
    if (estimating == 0 || estimating >= fit.time_s.size()) return std::nullopt;
    return fit.time_s[estimating];
  }
  return std::nullopt;
}

bool Subject::is_constant() const {
  return record && record->output.size() > 0 && !(record->output.maxCoeff() > record->output.minCoeff());
}

std::vector<const ReportedModel*> Subject::pictured() const {
  std::vector<const ReportedModel*> shown;
  if (!models.empty()) shown.push_back(&models.front());
  for (const ReportedModel& reported : models) {
    const bool is_wanted = runner_up.empty() || reported.model.name == runner_up;
    if (shown.size() < pictured_models && is_wanted && &reported != shown.front()) shown.push_back(&reported);
  }
  return shown;
}

Subject load_run(const fs::path& folder) {
  if (!record::is_run_folder(folder)) {
    throw DataError(folder.string() + ": no run folder; expected one, with run.json, or model files (" +
                    folder.string() + "/*.json)");
  }
  return load_run(record::OpenRun(folder));
}

Subject load_run(const record::OpenRun& run) {
  const fs::path& folder = run.files();
  Subject subject;
  std::error_code ignored;
  subject.name = run.path().filename().string();
  subject.folder = fs::absolute(run.path(), ignored).lexically_normal().string();
  const record::Manifest manifest = record::read_manifest(folder);
  // Only the process that writes the run may change run.json.
  if (!manifest.outcome) {
    throw DataError(run.path().string() +
                    ": the run is still going, or its process died; in the second case: eha runs recover");
  }
  subject.manifest = record::to_json(manifest);
  read_tables(folder, subject);
  record::SheetBeside sheet = record::sheet_beside(run.path());
  subject.leak = sheet.leak;
  subject.sheet = std::move(sheet.valve);
  subject.sheet_says = sheet.says;
  const Json& identification = subject.part("identification");
  for (const record::ModelEntry& entry :
       record::models_from_json(subject.part("identification", "models"), subject.name)) {
    const fs::path file = record::listed_file(folder, entry.file);
    if (fs::exists(file, ignored)) {
      subject.models.push_back(read_model(file, entry.file));
    } else {
      subject.notes.push_back(fmt::format("{} is listed in run.json and missing", entry.file));
    }
  }
  if (const Json& paper = subject.part("identification", "paper_procedure"); paper.is_array()) {
    for (const Json& model : paper) {
      subject.paper.push_back(ident::model_from_text(model.dump(), subject.name + "/run.json (paper_procedure)"));
    }
  }
  subject.reason = text_of(subject.part("identification", "recommendation", "reason"));
  sort_models(subject, {.model = text_of(subject.part("identification", "recommendation", "model")),
                        .runner_up = text_of(subject.part("identification", "recommendation", "runner_up"))});
  const auto take_record = [&] {
    record::LoadedRun loaded = record::read_run(run);
    subject.cause = identify::trip_cause(loaded);
    subject.record = std::move(loaded.record);
  };
  const Json& outcome = subject.part("outcome");
  if (!subject.fit.time_s.empty() && outcome.is_string() && !record::is_whole(outcome.get<std::string>())) {
    try {
      take_record();
    } catch (const DataError& error) {
      subject.notes.emplace_back(error.what());
    }
  }
  if (subject.fit.time_s.empty()) {
    if (!identification.is_null() && !subject.models.empty()) {
      subject.notes.push_back(
          fmt::format("There is no {}: `eha fit {}` writes it", identify::kFitFile, shell_word(run.path().string())));
    }
    for (const char* name : {kTrackRows, kTrackFile}) static_cast<void>(record::listed_file(folder, name));
    try {
      take_record();
      read_ended_trial(folder / kTrackFile, subject);
      if (const fs::path path = folder / kTrackRows; fs::exists(path, ignored)) subject.track = track_table(path);
    } catch (const DataError& error) {
      subject.notes.emplace_back(error.what());
    }
  }
  return subject;
}

Subject load_models(const std::vector<fs::path>& files) {
  Subject subject;
  subject.written = os::written_at(files);
  bool is_one_folder = true;
  for (const fs::path& file : files) {
    subject.models.push_back(read_model(file, file.string()));
    subject.name += (subject.name.empty() ? "" : ", ") + subject.models.back().model.name;
    is_one_folder = is_one_folder && file.parent_path() == files.front().parent_path();
  }
  if (files.size() > kMostNamed)
    subject.name = fmt::format("{} models", files.size()) + origin_text(subject.models, files.front());
  if (is_one_folder) {
    read_tables(folder_of_tables(files.front()), subject);
    subject.beside = recommended_beside(subject, files.front().parent_path());
  }
  // Keeps only the data of these models.
  std::erase_if(subject.fit.models, [&](const identify::FitColumn& column) {
    return std::none_of(subject.models.begin(), subject.models.end(),
                        [&](const ReportedModel& reported) { return reported.model.name == column.model; });
  });
  if (subject.fit.models.empty()) subject.fit = {};
  subject.paper_fit = {};
  // Chooses as `eha fit` did.
  std::vector<const ident::Model*> all;
  for (const ReportedModel& reported : subject.models) all.push_back(&reported.model);
  ident::Recommendation chosen = ident::recommend(all, {});
  if (subject.models.size() > 1) {
    subject.reason = chosen.reason;
  } else {
    chosen.model.clear();  // of one model none is recommended
  }
  if (const std::string better = better_than(subject, chosen.model); !better.empty()) {
    subject.reason = fmt::format(
        "its own verdict says that {} describes the record clearly better, and the file of that model is not among "
        "these, or another fit has replaced it; fit the record again",
        better);
    chosen.model.clear();
  }
  sort_models(subject, chosen);
  // Two that were named are to be seen beside each other.
  if (files.size() <= kMostCurves) subject.pictured_models = kMostCurves;
  return subject;
}

}  // namespace eha::report
