// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/run_summary.hpp"

#include <fmt/format.h>

#include "core/enum_names.hpp"
#include "core/error.hpp"
#include "daemon/record/one_line_texts.hpp"

namespace eha::record {
namespace {

using Json = nlohmann::ordered_json;

constexpr EnumNames<Purpose, 4> kPurposes{{{"models", Purpose::models},
                                           {"placing", Purpose::placing},
                                           {"valve_sheet", Purpose::valve_sheet},
                                           {"tracking", Purpose::tracking}}};

}  // namespace

RunSummary summary_of(const std::string& folder, const Manifest& manifest) {
  RunSummary summary{.folder = folder,
                     .outcome = std::string(outcome_text(manifest)),
                     .purpose = purpose_of(manifest),
                     .models = models_of(manifest)};
  if (manifest.identification && manifest.identification->recommendation) {
    summary.recommended = manifest.identification->recommendation->model;
  }
  if (const Json fault = fault_of(manifest); !fault.is_null()) summary.fault = fault.at("cause");
  const auto tick_s = manifest.other.find("sample_period_s");
  if (tick_s == manifest.other.end() || !tick_s->is_number()) return summary;
  // A skipped tick took its time as well.
  const auto ticks = manifest.report     ? manifest.report->counters.ticks + manifest.report->counters.skipped
                     : manifest.recovery ? manifest.recovery->rows
                                         : 0;
  summary.recorded_s = static_cast<double>(ticks) * tick_s->get<double>();
  return summary;
}

std::string reason_against_latest(const Manifest& manifest) {
  constexpr double kLeastShare = 0.5;
  if (!manifest.outcome || acquisition::is_whole(*manifest.outcome)) return {};
  const auto number = [&](const char* key) {
    const auto found = manifest.other.find(key);
    return found != manifest.other.end() && found->is_number() ? found->get<double>() : 0.0;
  };
  const double planned_s = number("samples_per_repetition") * number("repetitions") * number("sample_period_s");
  const double recorded_s = summary_of("", manifest).recorded_s;
  if (!(recorded_s < kLeastShare * planned_s)) return {};
  return fmt::format(
      "it is {} after {:.1f} of {:g} s, and a run that ended early becomes latest with half of its "
      "experiment or more",
      outcome_text(manifest), recorded_s, planned_s);
}

Json to_json(const RunSummary& summary) {
  return {{"folder", summary.folder},
          {"outcome", summary.outcome},
          {"fault", summary.fault.empty() ? Json(nullptr) : Json(summary.fault)},
          {"purpose", name_in(kPurposes, summary.purpose)},
          {"recorded_s", summary.recorded_s},
          {"models", to_json(summary.models)},
          {"recommended", summary.recommended.empty() ? Json(nullptr) : Json(summary.recommended)}};
}

RunSummary summary_from_json(Json json, const std::string& source) {
  make_one_line(json);
  try {
    RunSummary summary{.folder = json.at("folder"), .outcome = json.at("outcome")};
    if (const auto fault = json.find("fault"); fault != json.end() && fault->is_string()) summary.fault = *fault;
    summary.purpose = value_in(kPurposes, json.value("purpose", "")).value_or(Purpose::models);
    summary.recorded_s = json.value("recorded_s", 0.0);
    summary.models = models_from_json(json.at("models"), source + ": models");
    if (const auto name = json.find("recommended"); name != json.end() && name->is_string()) {
      summary.recommended = *name;
    }
    return summary;
  } catch (const Json::exception& error) {
    throw DataError(source + ": " + error.what());
  }
}

}  // namespace eha::record
