// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/manifest.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <utility>

#include "core/error.hpp"
#include "core/json_text.hpp"
#include "core/os/files.hpp"
#include "daemon/acquisition/clock.hpp"
#include "daemon/record/one_line_texts.hpp"
#include "daemon/record/plain_files.hpp"
#include "daemon/record/report_json.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_header.hpp"
#include "daemon/record/sha256.hpp"

namespace eha::record {
namespace {

using acquisition::kNanosecondsPerSecond;
using acquisition::LoopCounters;
using Json = nlohmann::ordered_json;

constexpr std::string_view kManifestSchema = "eha-run/1";

// The counters that `eha` shows; the others are in run.json only.
struct ShownCounter {
  const char* key;
  std::uint64_t LoopCounters::*member;
};
constexpr std::array<ShownCounter, 6> kShownCounters{{{"ticks", &LoopCounters::ticks},
                                                      {"late", &LoopCounters::late},
                                                      {"skipped", &LoopCounters::skipped},
                                                      {"timeouts", &LoopCounters::timeouts},
                                                      {"dropped", &LoopCounters::dropped},
                                                      {"clamped", &LoopCounters::clamped}}};

/// Reads members of an object; messages give the place of an error.
class Members {
 public:
  /// @throws DataError  not an object
  Members(const Json& object, std::string place) : object_(object), place_(std::move(place)) {
    if (!object.is_object()) fail("", "an object");
  }

  /// Reads a member; null and a missing member are the same. @throws DataError  of another type
  template <typename Value>
  [[nodiscard]] std::optional<Value> find(const char* key, const char* expected) const {
    const auto found = object_.find(key);
    if (found == object_.end() || found->is_null()) return std::nullopt;
    try {
      return found->get<Value>();
    } catch (const Json::exception&) {
      fail(key, expected);
    }
  }

  [[nodiscard]] std::string text(const char* key) const { return find<std::string>(key, "a text").value_or(""); }
  [[nodiscard]] std::uint64_t count(const char* key) const { return find<std::uint64_t>(key, "a number").value_or(0); }
  [[nodiscard]] bool flag(const char* key) const { return find<bool>(key, "true or false").value_or(false); }
  [[nodiscard]] std::optional<double> number(const char* key) const { return find<double>(key, "a number"); }
  /// @throws DataError  missing, or not a text
  [[nodiscard]] std::string required_text(const char* key) const {
    auto value = find<std::string>(key, "a text");
    if (!value) fail(key, "a text");
    return *value;
  }

  /// A member that has its own struct; null if there is none.
  [[nodiscard]] const Json& part(const char* key) const {
    static const Json kNull;
    const auto found = object_.find(key);
    return found == object_.end() ? kNull : *found;
  }
  [[nodiscard]] std::string place_of(const char* key) const { return place_ + ": " + key; }

 private:
  [[noreturn]] void fail(const char* key, const char* expected) const {
    throw DataError((*key == '\0' ? place_ : place_of(key)) + ": expected " + expected);
  }

  const Json& object_;
  std::string place_;
};

/// Calls read(element, place) for each element of a list; null is an empty one.
template <typename Read>
auto read_list(const Json& list, const std::string& place, Read&& read) {
  std::vector<decltype(read(list, place))> values;
  if (list.is_null()) return values;
  if (!list.is_array()) throw DataError(place + ": expected a list");
  for (const Json& element : list) values.push_back(read(element, place));
  return values;
}

FileEntry file_from_json(const Json& json, const std::string& place) {
  if (!json.is_object() || !json.contains("path") || !json["path"].is_string() || !json.contains("sha256") ||
      !json["sha256"].is_string()) {
    throw DataError(place + ": expected a path and a sha256 for each");
  }
  return {.path = json["path"], .sha256 = json["sha256"], .other = json};
}

ModelEntry model_from_json(const Json& json, const std::string& place) {
  const Members members(json, place);
  ModelEntry model{
      .name = members.text("name"),
      .file = members.text("file"),
      .accepted = members.flag("accepted"),
      .grade = members.text("grade"),
      .reasons = {},
      .estimation_r2_percent = members.number("estimation_r2_percent"),
      .seconds = members.number("seconds"),
      .validation_r2_percent = members.number("validation_r2_percent"),
      .validation_r2_percent_offset_reestimated = members.number("validation_r2_percent_offset_reestimated"),
      .usable_band_Hz = members.find<std::vector<double>>("usable_band_Hz", "a list of two numbers"),
      .other = json};
  model.reasons = members.find<std::vector<std::string>>("reasons", "a list of texts").value_or(model.reasons);
  return model;
}

ident::Recommendation recommendation_from_json(const Json& json, const std::string& place) {
  const Members members(json, place);
  return {.model = members.text("model"),
          .reason = members.text("reason"),
          .runner_up = members.text("runner_up"),
          .validation_chose = members.flag("needs_fresh_record"),
          .is_unclear = members.flag("is_unclear"),
          .is_lag_or_delay = members.flag("is_lag_or_delay"),
          .accepted_instead = members.text("accepted_instead")};
}

IdentificationEntry identification_from_json(const Json& json, const std::string& place) {
  const Members members(json, place);
  IdentificationEntry identification{.accepted = members.flag("accepted"),
                                     .models = models_from_json(members.part("models"), members.place_of("models")),
                                     .paper_procedure = members.find<Json>("paper_procedure", "a list"),
                                     .error = members.text("error"),
                                     .other = json};
  if (!members.part("recommendation").is_null()) {
    identification.recommendation =
        recommendation_from_json(members.part("recommendation"), members.place_of("recommendation"));
  }
  return identification;
}

ReportEntry report_from_json(const Json& json, const std::string& place) {
  const Members members(json, place);
  ReportEntry report{
      .description = members.text("description"), .write_error = members.text("write_error"), .counters = {}};
  if (members.part("counters").is_null()) return report;
  const Members counters(members.part("counters"), members.place_of("counters"));
  for (const ShownCounter& counter : kShownCounters) report.counters.*counter.member = counters.count(counter.key);
  return report;
}

JournalGap gap_from_json(const Json& json, const std::string& place) {
  const Members members(json, place);
  return {.at_ns = std::llround(members.number("at_s").value_or(0.0) * static_cast<double>(kNanosecondsPerSecond)),
          .rows = members.count("rows"),
          .blocks = static_cast<std::uint32_t>(members.count("blocks")),
          .bytes = members.count("bytes")};
}

RecoveryEntry recovery_from_json(const Json& json, const std::string& place) {
  const Members members(json, place);
  return {.utc = members.text("utc"),
          .rows = members.count("rows"),
          .torn_bytes = members.count("torn_bytes"),
          .end = members.part("end"),
          .gaps = read_list(members.part("gaps"), members.place_of("gaps"), gap_from_json)};
}

/// Sets a member, or leaves it out if there is no value and the file had none.
template <typename Value>
void set(Json& json, const char* key, const std::optional<Value>& value) {
  if (value) {
    json[key] = *value;
  } else if (json.contains(key)) {
    json[key] = nullptr;
  }
}

Json to_json(const FileEntry& file) {
  Json json = file.other;
  json["path"] = file.path;
  json["sha256"] = file.sha256;
  return json;
}

Json to_json(const JournalGap& gap) {
  return {{"at_s", static_cast<double>(gap.at_ns) / static_cast<double>(kNanosecondsPerSecond)},
          {"rows", gap.rows},
          {"blocks", gap.blocks},
          {"bytes", gap.bytes}};
}

Json to_json(const ModelEntry& model) {
  Json json = model.other;
  json["name"] = model.name;
  json["file"] = model.file;
  json["accepted"] = model.accepted;
  if (!model.grade.empty()) json["grade"] = model.grade;
  json["reasons"] = model.reasons;
  set(json, "estimation_r2_percent", model.estimation_r2_percent);
  set(json, "seconds", model.seconds);
  set(json, "validation_r2_percent", model.validation_r2_percent);
  set(json, "validation_r2_percent_offset_reestimated", model.validation_r2_percent_offset_reestimated);
  set(json, "usable_band_Hz", model.usable_band_Hz);
  return json;
}

Json to_json(const IdentificationEntry& identification) {
  Json json = identification.other;
  json["accepted"] = identification.accepted;
  json["models"] = to_json(identification.models);
  if (identification.recommendation) json["recommendation"] = record::to_json(*identification.recommendation);
  set(json, "paper_procedure", identification.paper_procedure);
  if (!identification.error.empty()) json["error"] = identification.error;
  return json;
}

template <typename Element>
Json list_of(const std::vector<Element>& elements) {
  Json list = Json::array();
  for (const Element& element : elements) list.push_back(to_json(element));
  return list;
}

std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  try {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      const std::filesystem::path relative = entry.path().lexically_relative(folder);
      if (entry.is_regular_file() && relative != kManifestFile && relative.extension() != ".tmp") {
        files.push_back(relative);
      }
    }
  } catch (const std::filesystem::filesystem_error& error) {
    os::throw_system_error("list", folder, error.code().value());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

bool is_whole(std::string_view outcome) noexcept { return acquisition::is_whole(outcome); }

std::string_view outcome_text(const Manifest& manifest) noexcept {
  return manifest.outcome ? acquisition::to_text(*manifest.outcome) : kInProgress;
}

std::string without_remedy(const std::string& description) {
  constexpr std::string_view kBetween = "; ";
  std::string kept = description.substr(0, description.find(kBetween));
  for (std::size_t at = description.find(kBetween); at != std::string::npos;) {
    const std::size_t begin = at + kBetween.size();
    at = description.find(kBetween, begin);
    const std::string part = description.substr(begin, at == std::string::npos ? at : at - begin);
    const bool is_fact = part.ends_with(acquisition::kRecordsLost) || part == acquisition::kOutputNotSafe ||
                         part == acquisition::kGuardDied;
    if (is_fact) kept.append(kBetween).append(part);
  }
  return kept;
}

acquisition::Outcome outcome_from_text(std::string_view name, const std::string& source) {
  if (const auto outcome = value_in(acquisition::kOutcomes, name)) return *outcome;
  throw DataError(source + ": \"" + std::string(name) + "\" is no outcome of a run");
}

Purpose purpose_of(const Manifest& manifest) {
  const auto found = manifest.other.find("experiment");
  if (found == manifest.other.end() || !found->is_object()) return Purpose::models;
  if (const auto sheet = found->find("characterises"); sheet != found->end() && *sheet == true) {
    return Purpose::valve_sheet;
  }
  if (const auto track = found->find("track"); track != found->end() && !track->is_null()) return Purpose::tracking;
  const auto place = found->find("place_in");
  return place != found->end() && place->is_number() ? Purpose::placing : Purpose::models;
}

std::vector<ModelEntry> models_of(const Manifest& manifest) {
  return manifest.identification ? manifest.identification->models : std::vector<ModelEntry>{};
}

Json to_json(const std::vector<ModelEntry>& models) { return list_of(models); }

std::vector<ModelEntry> models_from_json(const Json& list, const std::string& source) {
  return read_list(list, source, model_from_json);
}

Json to_json(const ident::Recommendation& recommendation) {
  const auto name = [](const std::string& model) { return model.empty() ? Json() : Json(model); };
  Json json{{"model", name(recommendation.model)},
            {"reason", recommendation.reason},
            {"runner_up", name(recommendation.runner_up)},
            {"needs_fresh_record", recommendation.validation_chose}};
  if (recommendation.is_unclear) json["is_unclear"] = true;
  if (recommendation.is_lag_or_delay) json["is_lag_or_delay"] = true;
  if (!recommendation.accepted_instead.empty()) json["accepted_instead"] = recommendation.accepted_instead;
  return json;
}

Json to_json(const Manifest& manifest) {
  Json json = manifest.other;
  json["outcome"] = outcome_text(manifest);
  set(json, "utc_end", manifest.utc_end);
  json["files"] = list_of(manifest.files);
  if (manifest.identification) json["identification"] = to_json(*manifest.identification);
  if (manifest.recovery) {
    json["recovery"] = {{"utc", manifest.recovery->utc},
                        {"rows", manifest.recovery->rows},
                        {"torn_bytes", manifest.recovery->torn_bytes},
                        {"end", manifest.recovery->end}};
    if (!manifest.recovery->gaps.empty()) json["recovery"]["gaps"] = list_of(manifest.recovery->gaps);
  }
  return json;
}

Manifest manifest_from_json(Json document, const std::string& source) {
  if (!document.is_object() || document.value("schema", Json()) != kManifestSchema) {
    throw DataError(source + ": not the manifest of a run (schema " + std::string(kManifestSchema) + ")");
  }
  make_one_line(document);
  const Members members(document, source);
  Manifest manifest;
  const std::string outcome = members.required_text("outcome");
  if (outcome != kInProgress) manifest.outcome = outcome_from_text(outcome, source);
  manifest.utc_end = members.find<std::string>("utc_end", "a text");
  manifest.files = read_list(members.part("files"), members.place_of("files"), file_from_json);
  const auto read_part = [&](const char* key, auto read, auto& target) {
    if (!members.part(key).is_null()) target = read(members.part(key), members.place_of(key));
  };
  read_part("report", report_from_json, manifest.report);
  read_part("identification", identification_from_json, manifest.identification);
  read_part("recovery", recovery_from_json, manifest.recovery);
  manifest.other = std::move(document);
  return manifest;
}

Manifest manifest_from_header(const Json& header) {
  Json document{{"schema", kManifestSchema}, {"outcome", kInProgress}, {"utc_start", nullptr}, {"utc_end", nullptr}};
  for (const auto& [key, value] : header.items()) {
    if (key != "schema") document[key] = value;
  }
  for (const char* key : {"host", "kernel", "files", "report", "identification"}) {
    if (!document.contains(key)) document[key] = nullptr;
  }
  make_one_line(document);
  Manifest manifest;
  manifest.other = std::move(document);
  return manifest;
}

Manifest new_manifest(const Json& header, const std::string& utc_start) {
  Manifest manifest = manifest_from_header(header);
  manifest.other["utc_start"] = utc_start;
  manifest.other["host"] = host_name();
  manifest.other["kernel"] = describe_kernel();
  return manifest;
}

Json fault_of(const Manifest& manifest) {
  const auto part = [](const Json& json, const char* key) {
    return json.is_object() && json.contains(key) ? json.at(key) : Json();
  };
  Json fault = part(part(manifest.other, "report"), "fault");
  if (fault.is_null() && manifest.recovery) fault = part(manifest.recovery->end, "fault");
  const Json of_rows = part(manifest.other, kFaultOfRows);
  if (fault.is_null() && of_rows.is_string()) fault = {{"cause", of_rows}};
  return part(fault, "cause").is_string() ? fault : Json();
}

bool reading_jumped(const Manifest& manifest) {
  const Json fault = fault_of(manifest);
  if (fault.is_null()) return false;
  if (fault.contains("has_jumped") && fault.at("has_jumped") == true) return true;
  const auto is = [&](acquisition::Fault one) { return fault.at("cause") == acquisition::to_text(one); };
  const auto number = [&](const char* key) {
    return fault.contains(key) && fault.at(key).is_number() ? fault.at(key).get<double>() : std::nan("");
  };
  if (is(acquisition::Fault::velocity_limit) && !fault.contains("value")) return true;
  acquisition::FaultReport report{.value = number("value"), .limit = number("limit")};
  for (const acquisition::Fault one : {acquisition::Fault::sensor_slip, acquisition::Fault::velocity_limit}) {
    if (is(one)) report.fault = one;
  }
  return acquisition::reading_jumped(report);
}

bool missed_motion(const Manifest& manifest) {
  const Json fault = fault_of(manifest);
  if (fault.is_null()) return false;
  const auto known = acquisition::fault_named(fault.at("cause").get<std::string>());
  return known && acquisition::names_motion(*known);
}

void put_report(Manifest& manifest, const acquisition::RunReport& report, const std::string& write_error) {
  manifest.outcome = report.outcome;
  manifest.utc_end = utc_now();
  const DisplayUnit unit(rig_units(manifest.other));
  manifest.report = {acquisition::describe(report, unit), write_error, report.counters};
  Json& json = manifest.other["report"];
  json = describe_report(report, unit);
  if (!write_error.empty()) json["write_error"] = write_error;
}

void require_plain_files(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  constexpr int kDeepest = 2;                                      // models/rejected
  constexpr std::uintmax_t kMostBytes = std::uintmax_t{4} << 30U;  // 10^7 rows, the most of a run, take less than 1 GiB
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code ignored;
    const fs::file_type type = entry->status(ignored).type();
    if (type == fs::file_type::fifo || type == fs::file_type::character || type == fs::file_type::block ||
        type == fs::file_type::socket) {
      throw DataError(os::shown(entry->path()) + ": a pipe or a device, not a file of a run; remove it");
    }
    if (type == fs::file_type::regular) {
      const std::uintmax_t bytes = fs::file_size(entry->path(), ignored);
      if (!ignored && bytes > kMostBytes) {
        throw DataError(fmt::format("{}: {} GiB, where no file of a run has more than {}; remove it",
                                    os::shown(entry->path()), bytes >> 30U, kMostBytes >> 30U));
      }
    }
    if (entry.depth() >= kDeepest) entry.disable_recursion_pending();
  }
}

Manifest read_manifest(const std::filesystem::path& folder) {
  require_plain_files(folder);
  const std::filesystem::path path = folder / kManifestFile;
  return manifest_from_json(parse_json_text<Json>(os::read_file(path)), os::shown(path));
}

void write_manifest(const std::filesystem::path& folder, Manifest& manifest) {
  std::vector<FileEntry> entries;
  for (const std::filesystem::path& file : files_in(folder)) {
    const std::string path = file.generic_string();
    const auto known = std::find_if(manifest.files.begin(), manifest.files.end(),
                                    [&](const FileEntry& entry) { return entry.path == path; });
    if (known != manifest.files.end() && (path == kRawFile || path == kJournalFile)) {
      entries.push_back(*known);
      continue;
    }
    entries.push_back({.path = path,
                       .sha256 = sha256_of_file(folder / file),
                       .other = {{"path", path}, {"bytes", std::filesystem::file_size(folder / file)}}});
  }
  manifest.files = std::move(entries);
  os::write_file_atomically(folder / kManifestFile,
                            to_json(manifest).dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

void write_identification(const std::filesystem::path& folder, IdentificationEntry identification) {
  Manifest manifest = read_manifest(folder);
  manifest.identification = std::move(identification);
  write_manifest(folder, manifest);
}

std::string utc_now() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now));
}

}  // namespace eha::record
