// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/config_json.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <variant>

#include "daemon/record/json_keys.hpp"
#include "hal/backends/backend.hpp"
#include "ident/excitation/excitation.hpp"

namespace eha::record {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const ident::Excitation& excitation) {
  Json json{{"kind", ident::name_of(excitation.kind)}, {"offset_V", excitation.offset_V}};
  json.update(std::visit([](const auto& options) { return JsonKeys::keys_of(options); }, excitation.kind));
  return json;
}

void add_start(Json& json, const std::optional<config::Place>& start) {
  if (start) json["start_in"] = start->displacement_in;
}

// The members of each kind.

void add_kind(Json& json, const config::Played& played) {
  json["excitation"] = to_json(played.excitation);
  add_start(json, played.start);
  if (played.hold) json["hold"] = JsonKeys::keys_of(*played.hold);
  if (played.precision) json["precision"] = JsonKeys::keys_of(*played.precision);
}

void add_kind(Json& json, const config::Placing& placing) {
  json["place_in"] = placing.place.displacement_in;
  json["way_back"] = placing.brings_back;
  if (placing.from_in) json["from_in"] = *placing.from_in;
}

void add_kind(Json& json, const config::SheetRun& sheet) {
  json["characterises"] = true;
  add_start(json, sheet.start);
}

void add_kind(Json& json, const config::Tracking& tracking) {
  json["track"] = tracking.track.controller.name;
  if (const std::string& file = tracking.track.controller_file; !file.empty()) json["controller_file"] = file;
  json["controller_model"] = tracking.track.controller.provenance.model;
  add_start(json, tracking.start);
}

}  // namespace

Json to_json(const config::RigConfig& rig) {
  Json json = JsonKeys::keys_of(rig);
  if (!rig.limits.closed_loop_max_V) json["limits"].erase("closed_loop_max_V");
  for (const char* table : {"following", "sensor"}) {
    if (!json.contains(table)) json[table] = nullptr;
  }
  json[std::string(hal::name_of(rig.backend))] =
      std::visit([](const auto& options) { return JsonKeys::keys_of(options); }, rig.backend);
  const hal::Conversion conversion = hal::conversion_of(rig.backend);
  json["calibration"] = {{"scale_in_per_V", conversion.scale_in_per_V}, {"offset_in", conversion.offset_in}};
  if (!conversion.calibration_date.empty()) json["calibration"]["date"] = conversion.calibration_date;
  std::error_code ignored;
  const std::filesystem::path file = std::filesystem::absolute(rig.file_name, ignored);
  json["file"] = ignored || rig.file_name.empty() ? Json(nullptr) : Json(file.string());
  json["text"] = rig.text;
  return json;
}

Json to_json(const config::ExperimentConfig& experiment) {
  Json models = Json::array();
  for (const ident::StructureOptions& model : experiment.models) models.push_back(model.name);
  // Every kind has the members of all kinds.
  Json json{{"name", experiment.name}, {"excitation", nullptr},      {"place_in", nullptr},        {"way_back", false},
            {"characterises", false},  {"track", nullptr},           {"start_in", nullptr},        {"hold", nullptr},
            {"precision", nullptr},    {"controller_file", nullptr}, {"controller_model", nullptr}};
  std::visit([&](const auto& kind) { add_kind(json, kind); }, experiment.kind);
  json["duration_s"] = experiment.duration_s;
  json["repetitions"] = experiment.repetitions;
  json["record"] = JsonKeys::keys_as<config::RecordKeys>(experiment.fit);
  json["identification"] = JsonKeys::keys_of(experiment.identification());
  json["models"] = std::move(models);
  json["acceptance"] = JsonKeys::keys_as<config::AcceptanceKeys>(experiment.acceptance);
  json["text"] = experiment.text;
  return json;
}

}  // namespace eha::record
