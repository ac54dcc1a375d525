// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/config_json.hpp"

#include <cmath>
#include <string_view>

// Free functions that nlohmann-json looks for beside the structs; each member keeps its name.
namespace eha::hal {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SimOptions, bore_mm, rod_mm, stroke_mm, initial_displacement_in, cap_dead_volume_cm3,
                                   rod_dead_volume_cm3, leakage_cm3_per_s_per_bar, moving_mass_kg,
                                   end_stop_stiffness_N_per_mm, end_stop_damping_N_s_per_mm, coulomb_friction_N,
                                   static_friction_N, viscous_friction_N_s_per_mm, stribeck_velocity_mm_per_s,
                                   friction_regularisation_mm_per_s, bulk_modulus_bar, supply_pressure_bar,
                                   tank_pressure_bar, valve_full_scale_V, valve_rated_flow_L_per_min,
                                   valve_rated_drop_bar, valve_natural_frequency_Hz, valve_damping_ratio,
                                   valve_dead_band_V, valve_null_offset_V, command_min_V, command_max_V, feedback_min_V,
                                   feedback_max_V, resolution_bits, scale_in_per_V, offset_in, sensor_noise_V, seed,
                                   sub_step_us)
}  // namespace eha::hal

namespace eha::config {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RigLimits, command_min_V, command_max_V, slew_V_per_s, safe_V, travel_min_in,
                                   travel_max_in, stopping_deceleration_in_per_s2, velocity_limit_in_per_s,
                                   frozen_sensor_s)
}  // namespace eha::config

namespace eha::record {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinity: an absent limit is null.
Json finite_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string_view name_of(ident::ExcitationKind kind) {
  switch (kind) {
    case ident::ExcitationKind::multisine:
      return "multisine";
    case ident::ExcitationKind::odd_random_multisine:
      return "odd_random_multisine";
    case ident::ExcitationKind::prms:
      return "prms";
    case ident::ExcitationKind::chirp:
      return "chirp";
    case ident::ExcitationKind::gaussian:
      return "gaussian";
    case ident::ExcitationKind::step:
      return "step";
    case ident::ExcitationKind::sine:
      return "sine";
  }
  return "unknown";
}

Json to_json(const ident::ExcitationOptions& excitation) {
  Json tones = Json::array();
  for (const ident::Tone& tone : excitation.tones) {
    tones.push_back(
        {{"frequency_Hz", tone.frequency_Hz}, {"amplitude_V", tone.amplitude_V}, {"phase_rad", tone.phase_rad}});
  }
  return {{"kind", name_of(excitation.kind)},
          {"tones", std::move(tones)},
          {"offset_V", excitation.offset_V},
          {"amplitude_V", excitation.amplitude_V},
          {"frequency_min_Hz", excitation.frequency_min_Hz},
          {"frequency_max_Hz", excitation.frequency_max_Hz},
          {"levels", excitation.levels},
          {"hold_s", excitation.hold_s},
          {"seed", excitation.seed}};
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
              {"abort_total_late", rig.realtime.abort_total_late}}}};
  if (rig.backend == config::Backend::sim) {
    json["sim"] = nlohmann::json(rig.sim);
    json["calibration"] = {{"scale_in_per_V", rig.sim.scale_in_per_V}, {"offset_in", rig.sim.offset_in}};
  } else {
    json["calibration"] = {{"scale_in_per_V", rig.comedi.scale_in_per_V},
                           {"offset_in", rig.comedi.offset_in},
                           {"date", rig.comedi.calibration_date}};
  }
  json["text"] = rig.text;
  return json;
}

Json to_json(const config::ExperimentConfig& experiment) {
  const ident::FitOptions& fit = experiment.fit;
  Json models = Json::array();
  for (const ident::StructureOptions& model : experiment.models) models.push_back(model.name);
  return {{"name", experiment.name},
          {"excitation", to_json(experiment.excitation)},
          {"duration_s", experiment.duration_s},
          {"repetitions", experiment.repetitions},
          {"record", {{"discard_s", fit.discard_s}, {"decimation", fit.decimation}, {"split", fit.split}}},
          {"identification",
           {{"procedure", fit.procedure == ident::Procedure::paper ? "paper" : "default"}, {"seed", fit.seed}}},
          {"models", std::move(models)},
          {"acceptance",
           {{"min_validation_r2_percent", experiment.acceptance.min_validation_r2_percent},
            {"max_abs_error_in", finite_or_null(experiment.acceptance.max_abs_error)},
            {"require_stable", experiment.acceptance.require_stable},
            {"min_stability_margin_rad", experiment.acceptance.min_stability_margin_rad}}},
          {"text", experiment.text}};
}

}  // namespace eha::record
