// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/config_json.hpp"

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/keys.hpp"
#include "core/volts_file.hpp"
#include "daemon/record/sha256.hpp"
#include "hal/backends/backend.hpp"
#include "ident/excitation/excitation.hpp"

namespace eha::config {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RigLimits, command_min_V, command_max_V, slew_V_per_s, safe_V, travel_min_in,
                                   travel_max_in, stopping_deceleration_in_per_s2, velocity_limit_in_per_s,
                                   frozen_sensor_s)
}  // namespace eha::config

namespace eha::record {
namespace {

using Json = nlohmann::ordered_json;

/// Writes the keys of a kind, see core/keys.hpp.
class JsonKeys {
 public:
  explicit JsonKeys(Json& json) : json_(json) {}

  void number(std::string_view key, double value, const Range&, Need = Need::required) { set(key, value); }
  void number(std::string_view key, const std::optional<double>& value, const Range&) {
    set(key, value ? Json(*value) : Json(nullptr));
  }
  template <class Integer>
  void integer(std::string_view key, Integer value, std::int64_t, std::int64_t, Need = Need::required) {
    set(key, value);
  }
  void text(std::string_view key, const std::string& value) { set(key, value); }
  template <class Value, class Choices>
  void choice(std::string_view key, Value value, const Choices& choices) {
    for (const auto& [name, choice] : choices) {
      if (choice == value) set(key, name);
    }
  }
  void number_or_unknown(std::string_view key, const std::optional<double>& value) {
    set(key, value ? Json(*value) : Json("unknown"));
  }
  template <class Table>
  void table(std::string_view key, const Table& table) {
    set(key, keys_of(table));
  }
  template <class Table>
  void optional_table(std::string_view key, const std::optional<Table>& table) {
    if (table) set(key, keys_of(*table));
  }
  template <class Table>
  void table_or_none(std::string_view key, const std::optional<Table>& table) {
    set(key, table ? keys_of(*table) : Json("none"));
  }

  template <class Table>
  void tables(std::string_view key, const std::vector<Table>& tables) {
    Json list = Json::array();
    for (const Table& table : tables) list.push_back(keys_of(table));
    set(key, std::move(list));
  }
  void volts_file(std::string_view key, const VoltsFile& file) {
    set(key, {{"name", file.name},
              {"rows", file.volts_V.size()},
              {"sha256", sha256_of(std::as_bytes(std::span(file.volts_V)))}});
  }

  template <class Table>
  static Json keys_of(const Table& table) {
    Json json = Json::object();
    JsonKeys keys(json);
    Table::visit_keys(table, keys);
    return json;
  }

 private:
  void set(std::string_view key, Json value) { json_[std::string(key)] = std::move(value); }

  Json& json_;
};

/// JSON has no infinity: an absent limit is null.
Json finite_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json to_json(const ident::Excitation& excitation) {
  Json json{{"kind", ident::name_of(excitation.kind)}, {"offset_V", excitation.offset_V}};
  json.update(std::visit([](const auto& options) { return JsonKeys::keys_of(options); }, excitation.kind));
  return json;
}

}  // namespace

Json to_json(const config::RigConfig& rig) {
  Json json{{"name", rig.name},
            {"limits", nlohmann::json(rig.limits)},
            {"realtime",
             {{"sample_period_s", rig.realtime.sample_period_s},
              {"priority", rig.realtime.priority},
              {"cpu", rig.realtime.cpu ? Json(*rig.realtime.cpu) : Json(nullptr)},
              {"abort_consecutive_late", rig.realtime.abort_consecutive_late},
              {"abort_total_late", rig.realtime.abort_total_late},
              {"stall_limit_s", rig.realtime.stall_limit_s ? Json(*rig.realtime.stall_limit_s) : Json(nullptr)}}}};
  if (rig.limits.closed_loop_max_V) json["limits"]["closed_loop_max_V"] = *rig.limits.closed_loop_max_V;
  if (!rig.units.empty()) json["units"] = rig.units;
  json["following"] = rig.limits.following ? JsonKeys::keys_of(*rig.limits.following) : Json(nullptr);
  json["sensor"] = rig.limits.sensor ? JsonKeys::keys_of(*rig.limits.sensor) : Json(nullptr);
  json[std::string(hal::name_of(rig.backend))] =
      std::visit([](const auto& options) { return JsonKeys::keys_of(options); }, rig.backend);
  const hal::Conversion conversion = hal::conversion_of(rig.backend);
  json["calibration"] = {{"scale_in_per_V", conversion.scale_in_per_V}, {"offset_in", conversion.offset_in}};
  if (!conversion.calibration_date.empty()) json["calibration"]["date"] = conversion.calibration_date;
  json["text"] = rig.text;
  return json;
}

Json to_json(const config::ExperimentConfig& experiment) {
  const ident::FitOptions& fit = experiment.fit;
  Json models = Json::array();
  for (const ident::StructureOptions& model : experiment.models) models.push_back(model.name);
  Json hold = nullptr;
  if (experiment.hold) {
    const auto& gain = experiment.hold->gain_V_per_in;
    hold = {{"gain_V_per_in", gain ? Json(*gain) : Json(nullptr)}};
  }
  return {
      {"name", experiment.name},
      {"excitation", experiment.is_fitted() ? to_json(experiment.excitation) : Json(nullptr)},
      {"place_in", experiment.place_in ? Json(*experiment.place_in) : Json(nullptr)},
      {"way_back", experiment.brings_back},
      {"characterises", experiment.characterises},
      {"track", experiment.track ? Json(experiment.track->controller.name) : Json(nullptr)},
      {"start_in", experiment.start_in ? Json(*experiment.start_in) : Json(nullptr)},
      {"hold", std::move(hold)},
      {"precision", experiment.precision ? Json{{"gain_percent", experiment.precision->gain_percent}} : Json(nullptr)},
      {"duration_s", experiment.duration_s},
      {"repetitions", experiment.repetitions},
      {"record",
       {{"discard_s", fit.discard_s},
        {"decimation", fit.decimation},
        {"split", fit.split},
        {"input_before_V", fit.input_before ? Json(*fit.input_before) : Json(nullptr)}}},
      {"identification",
       {{"procedure", experiment.compares_with_paper             ? "both"
                      : fit.procedure == ident::Procedure::paper ? "paper"
                                                                 : "default"},
        {"seed", fit.seed}}},
      {"models", std::move(models)},
      {"acceptance",
       {{"min_validation_r2_percent", experiment.acceptance.min_validation_r2_percent},
        {"max_abs_error_in", finite_or_null(experiment.acceptance.max_abs_error)},
        {"require_stable", experiment.acceptance.require_stable},
        {"min_stability_margin_rad", experiment.acceptance.min_stability_margin_rad},
        {"usable_gain_error_dB", experiment.acceptance.usable_gain_error_dB},
        {"usable_phase_error_deg", experiment.acceptance.usable_phase_error_deg}}},
      {"text", experiment.text}};
}

}  // namespace eha::record
