// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/run_store.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>
#include <vector>

#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "core/json_text.hpp"
#include "core/os/files.hpp"
#include "daemon/acquisition/run_report.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_header.hpp"
#include "daemon/record/sheet_beside.hpp"

namespace eha::web {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kLongestName = 200;

bool is_name(std::string_view text) noexcept {
  const auto is_allowed = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' || c == '.';
  };
  return !text.empty() && text.size() <= kLongestName && text.front() != '.' &&
         std::all_of(text.begin(), text.end(), is_allowed);
}

/// Opens a file below a folder, one name of the path after the other, none of them a link. Not by openat2, which
/// systemd's RestrictSUIDSGID= forbids.
/// @returns none for a name that does not pass is_name, such as ".."
os::FileDescriptor open_beneath(os::FileDescriptor folder, std::string_view path) {
  for (std::size_t slash = path.find('/'); folder && slash != std::string_view::npos; slash = path.find('/')) {
    const std::string name(path.substr(0, slash));
    if (!is_name(name)) return {};
    folder = os::FileDescriptor(openat(folder.get(), name.c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    path.remove_prefix(slash + 1);
  }
  if (!folder || !is_name(path)) return {};
  // O_NONBLOCK: a pipe of that name must not block the thread.
  return os::FileDescriptor(
      openat(folder.get(), std::string(path).c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
}

/// Returns the text of a run.json or valve_sheet.json.
std::string content_of(const RunFile& file, std::string_view id, std::string_view name = record::kManifestFile) {
  if (file.size > RunStore::kLargestManifest) {
    throw DataError(
        fmt::format("{}: its {} has {} bytes; expected at most {}", id, name, file.size, RunStore::kLargestManifest));
  }
  std::string text(file.size, '\0');
  text.resize(os::read_up_to_at(file.descriptor, text.data(), text.size(), 0, "a file of a run"));
  return text;
}

constexpr const char* kOfValve = "a valve sheet";

/// What a run is for that fits no model; null for a run of models.
const char* instead_of_models(record::Purpose purpose) {
  switch (purpose) {
    case record::Purpose::models:
      return nullptr;
    case record::Purpose::placing:
      return "a move to a place";
    case record::Purpose::valve_sheet:
      return kOfValve;
    case record::Purpose::tracking:
      return "a controller's trial";
  }
  return nullptr;
}

/// "valve: null -0.200 V, half dead band 0.151 V, 0.148 in/(V s) extending, 0.131 in/(V s) retracting"
std::string numbers_of(const Json& sheet, const DisplayUnit& unit) {
  const auto value = [&](const char* key) {
    const Json& measured = sheet.value(key, Json());
    return measured.is_object() && measured.contains("value") && measured.at("value").is_number()
               ? measured.at("value").get<double>()
               : std::nan("");
  };
  const double gain = unit.factor("in");
  const std::string gain_unit = unit.of("in") + "/(V s)";
  return fmt::format("valve: null {:.3f} V, half dead band {:.3f} V, {:.3g} {} extending, {:.3g} {} retracting",
                     value("null_V"), value("dead_band_V"), gain * value("gain_positive_in_per_V_s"), gain_unit,
                     gain * value("gain_negative_in_per_V_s"), gain_unit);
}

/// Whether the record of a run that tripped shows more of its cause than the fault: at a limit, and of a trial.
bool is_told_by_its_record(const record::Manifest& manifest) {
  if (!manifest.report || manifest.outcome != acquisition::Outcome::faulted) return false;
  const std::string& end = manifest.report->description;
  const std::string_view fault = std::string_view(end).substr(0, end.find(' '));
  return record::purpose_of(manifest) == record::Purpose::tracking ||
         (record::purpose_of(manifest) == record::Purpose::models &&
          (fault == acquisition::to_text(acquisition::Fault::travel_limit) ||
           fault == acquisition::to_text(acquisition::Fault::velocity_limit)));
}

/// Whether a run was played for models, whose response is measured; false where its manifest cannot be read.
bool is_for_models(const RunStore& store, const std::string& id) {
  try {
    const auto manifest = parse_json_text<Json>(store.manifest(id));
    return record::purpose_of(record::manifest_from_json(manifest, id + "/run.json")) == record::Purpose::models;
  } catch (const std::exception&) {
    return false;
  }
}

/// Returns the members from a manifest.
Json describe_manifest(const RunFile& file, const std::string& id) {
  const record::Manifest manifest =
      record::manifest_from_json(parse_json_text<Json>(content_of(file, id)), id + "/run.json");
  Json said{{"id", id},
            {"name", manifest.other.value("name", "")},
            {"started", manifest.other.value("utc_start", Json())},
            {"outcome", record::outcome_text(manifest)},
            {"grade", nullptr},
            {"recommended", nullptr},
            {"measured", nullptr},
            {"reason", nullptr}};
  if (manifest.report && !manifest.report->description.empty()) {
    const std::string& end = manifest.report->description;
    // What the record shows is the one remedy, as of the terminal.
    said["reason"] = is_told_by_its_record(manifest)
                         ? fmt::format("{}; `eha runs show {}` says what to do", record::without_remedy(end), id)
                         : end;
  }
  if (const char* what = instead_of_models(record::purpose_of(manifest));
      what != nullptr && record::models_of(manifest).empty()) {
    said["measured"] = what;
    said["units"] = record::rig_units(manifest.other);
    if (manifest.identification && !manifest.identification->error.empty()) {
      said["reason"] = manifest.identification->error;
    }
  } else if (manifest.identification) {
    const record::IdentificationEntry& identification = *manifest.identification;
    said["grade"] = identification.accepted ? "accepted" : "rejected";
    if (!identification.error.empty()) said["reason"] = identification.error;
    if (identification.recommendation) {
      const Json recommendation = record::to_json(*identification.recommendation);
      said["recommended"] = recommendation.at("model");
      said["reason"] = recommendation.at("reason");
    }
    for (const record::ModelEntry& model : identification.models) {
      if (said["recommended"] == model.name && !model.grade.empty()) said["grade"] = model.grade;
    }
  }
  Json files = Json::array();
  files.push_back(record::kManifestFile);
  for (const record::FileEntry& entry : manifest.files) {
    if (is_download(entry.path) && entry.path != record::kManifestFile) files.push_back(entry.path);
  }
  said["files"] = std::move(files);
  return said;
}

/// Returns the newest names of run folders, newest first: they begin with the time.
std::vector<std::string> newest_names(const fs::path& folder, std::size_t most) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator item(folder, error), end; !error && item != end; item.increment(error)) {
    std::string name = item->path().filename().string();
    // Accepts run folders only; "latest" is a link.
    if (is_run_id(name) && !item->is_symlink(error) && item->is_directory(error)) names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end(), std::greater<>());
  if (names.size() > most) names.resize(most);
  return names;
}

}  // namespace

bool is_run_id(std::string_view text) noexcept { return is_name(text); }

bool is_download(std::string_view path) noexcept {
  if (path == record::kManifestFile || path == record::kRawFile) return true;
  const auto has_kind = [&](std::string_view folder, std::string_view ending) {
    return path.starts_with(folder) && path.ends_with(ending) && path.size() > folder.size() + ending.size() &&
           is_name(path.substr(folder.size()));
  };
  return has_kind("", ".csv") || has_kind("models/", ".json") || has_kind("models/rejected/", ".json");
}

fs::path RunFile::path() const { return fmt::format("/proc/self/fd/{}", descriptor.get()); }

void RunStore::set_folder(fs::path folder) {
  const std::lock_guard lock(mutex_);
  folder_ = std::move(folder);
}

fs::path RunStore::folder() const {
  const std::lock_guard lock(mutex_);
  return folder_;
}

std::optional<RunFile> RunStore::open(std::string_view id, std::string_view path) const {
  const fs::path root = folder();
  if (root.empty() || !is_run_id(id)) return std::nullopt;
  os::FileDescriptor runs(::open(root.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  RunFile file{.descriptor = open_beneath(std::move(runs), fmt::format("{}/{}", id, path))};
  struct stat status {};
  if (!file.descriptor || fstat(file.descriptor.get(), &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  file.size = static_cast<std::uint64_t>(status.st_size);
  file.modified_ns = status.st_mtim.tv_sec * 1'000'000'000 + status.st_mtim.tv_nsec;
  return file;
}

std::string RunStore::manifest(std::string_view id) const {
  const std::optional<RunFile> file = open(id, record::kManifestFile);
  if (!file) throw DataError(fmt::format("{}: its run.json is missing or cannot be read", id));
  return content_of(*file, id);
}

std::string RunStore::newest() const {
  // A run in preparation has none yet.
  constexpr std::size_t kLookedAt = 20;
  std::string any;
  for (std::string& id : newest_names(folder(), kLookedAt)) {
    if (!open(id, record::kJournalFile)) continue;
    if (is_for_models(*this, id)) return std::move(id);
    if (any.empty()) any = std::move(id);
  }
  return any;
}

Json RunStore::describe(const std::string& id) {
  const std::optional<RunFile> file = open(id, record::kManifestFile);
  if (!file) {
    known_.erase(id);
    return {{"id", id}, {"outcome", "unreadable"}, {"error", "its run.json is missing or cannot be read"}};
  }
  Known& known = known_[id];
  if (known.said.is_null() || known.size != file->size || known.modified_ns != file->modified_ns) {
    known = {file->size, file->modified_ns, nullptr};
    try {
      known.said = describe_manifest(*file, id);
    } catch (const std::exception& error) {
      known.said = {{"id", id}, {"outcome", "unreadable"}, {"error", error.what()}};
    }
  }
  Json said = known.said;
  if (said.contains("files")) said["has_report"] = open(id, "report.html").has_value();
  // Of its own file, which comes after the manifest.
  if (said.contains("units") && said.at("measured") == kOfValve && said.at("outcome") != record::kInProgress) {
    const std::optional<RunFile> sheet = open(id, record::kSheetFile);
    try {
      said["measured"] = sheet ? numbers_of(parse_json_text<Json>(content_of(*sheet, id, record::kSheetFile)),
                                            DisplayUnit(said.at("units")))
                               : std::string("no valve sheet");
    } catch (const std::exception& error) {
      said["measured"] = error.what();
    }
  }
  said.erase("units");
  return said;
}

Json RunStore::list(std::size_t most) {
  const std::lock_guard lock(list_mutex_);
  const std::vector<std::string> names = newest_names(folder(), most);
  std::erase_if(known_,
                [&](const auto& item) { return std::find(names.begin(), names.end(), item.first) == names.end(); });
  Json runs = Json::array();
  for (const std::string& name : names) runs.push_back(describe(name));
  return runs;
}

}  // namespace eha::web
