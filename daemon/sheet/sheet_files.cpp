// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/files.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/report/report.hpp"
#include "daemon/sheet/run_sheet.hpp"

namespace eha::sheet {
namespace {

using Json = nlohmann::ordered_json;
using ident::Measured;

Json json_of(const Measured& measured) { return {{"value", measured.value}, {"half_width95", measured.half_width}}; }

Json json_of(const std::optional<Measured>& measured) { return measured ? json_of(*measured) : Json(nullptr); }

Json json_of(const ident::AmplitudeResponse& response) {
  Json points = Json::array();
  for (const ident::ResponsePoint& point : response.points) {
    points.push_back({{"frequency_Hz", point.frequency_Hz},
                      {"gain_dB", point.gain_dB},
                      {"phase_deg", point.phase_deg},
                      {"gain_half_width95_dB", point.gain_half_width_dB},
                      {"phase_half_width95_deg", point.phase_half_width_deg}});
  }
  return {{"amplitude_percent", response.percent},
          {"amplitude_V", response.amplitude_V},
          {"played", response.is_played},
          {"minus_3dB_Hz", json_of(response.minus_3dB_Hz)},
          {"minus_90deg_Hz", json_of(response.minus_90deg_Hz)},
          {"points", std::move(points)}};
}

}  // namespace

Json to_json(const RunSheet& run) {
  const ident::ValveSheet& sheet = run.sheet;
  const config::Following following = following_of(run);
  Json responses = Json::array();
  for (const ident::AmplitudeResponse& response : sheet.responses) responses.push_back(json_of(response));
  return {{"schema", "eha-valve-sheet/1"},
          {"run", run.folder.string()},
          {"rig", run.rig.name},
          {"null_V", json_of(sheet.null_V)},
          {"dead_band_V", json_of(sheet.dead_band_V)},
          {"gain_positive_in_per_V_s", json_of(sheet.gain_positive_in_per_V_s)},
          {"gain_negative_in_per_V_s", json_of(sheet.gain_negative_in_per_V_s)},
          {"hysteresis_V", sheet.has_hysteresis ? json_of(sheet.hysteresis_V) : Json(nullptr)},
          {"creep_in_per_s", json_of(sheet.creep_in_per_s)},
          {"noise_in", sheet.noise_in},
          {"lag_s", sheet.lag_s},
          {"responses", std::move(responses)},
          {"highest_Hz", sheet.highest_Hz},
          {"natural_frequency_Hz", json_of(sheet.natural_frequency_Hz)},
          {"damping_ratio", json_of(sheet.damping_ratio)},
          {"following",
           {{"gain_positive_in_per_V_s", following.gain_positive_in_per_V_s},
            {"gain_negative_in_per_V_s", following.gain_negative_in_per_V_s},
            {"null_V", following.null_V},
            {"dead_band_V", following.dead_band_V},
            {"limit_in", following.limit_in},
            {"pressure_delay_s", following.pressure_delay_s},
            {"null_uncertainty_V", *following.null_uncertainty_V},
            {"dead_band_uncertainty_V", *following.dead_band_uncertainty_V},
            {"gain_uncertainty_percent", *following.gain_uncertainty_percent}}}};
}

std::vector<std::string> write_sheet(const RunSheet& run, const DisplayUnit& unit) {
  std::vector<std::string> missing;
  os::write_file_atomically(run.opened.files() / kSheetFile, to_json(run).dump(2) + "\n");
  os::write_file_atomically(run.opened.files() / report::kReportFile, sheet_page(run, unit, missing));
  record::Manifest manifest = record::read_manifest(run.opened.files());
  record::write_manifest(run.opened.files(), manifest);
  return missing;
}

}  // namespace eha::sheet
