// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/tune/tune_inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "config/valve_estimate.hpp"
#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "core/millimetre_key.hpp"
#include "daemon/tune/following_agreement.hpp"
#include "hal/backends/backend.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/output_unit.hpp"

namespace eha::tune {
namespace {

constexpr double kStdsOf95Percent = 1.96;
constexpr int kBitsOfACard = 16;
constexpr double kLsbsOfNoise = 3.0;  // if the noise is unknown

ident::ValveNumbers numbers_of(const ident::ValveSheet& sheet) {
  const auto std_of = [](const ident::Measured& m) { return m.half_width / kStdsOf95Percent; };
  return {.null = sheet.null_V.value,
          .dead_band = std::max(0.0, sheet.dead_band_V.value),
          .gain_positive = sheet.gain_positive_in_per_V_s.value,
          .gain_negative = sheet.gain_negative_in_per_V_s.value,
          .null_std = std_of(sheet.null_V),
          .dead_band_std = std_of(sheet.dead_band_V),
          .gain_std_share = std::max(std_of(sheet.gain_positive_in_per_V_s) / sheet.gain_positive_in_per_V_s.value,
                                     std_of(sheet.gain_negative_in_per_V_s) / sheet.gain_negative_in_per_V_s.value)};
}

ident::ValveNumbers numbers_of(const config::Following& following) {
  const config::ValveEstimate valve = config::valve_estimate(following);
  const config::ValveUncertainty uncertainty = config::valve_uncertainty(following);
  return {.null = valve.null_V,
          .dead_band = valve.dead_band_V,
          .gain_positive = valve.gain_positive_in_per_V_s,
          .gain_negative = valve.gain_negative_in_per_V_s,
          .null_std = uncertainty.null_V,
          .dead_band_std = uncertainty.dead_band_V,
          .gain_std_share = uncertainty.gain_share};
}

ident::Model in_inches(ident::Model model) {
  const DisplayUnit inches("in");
  if (model.input_unit != "V" || inches.of(model.output_unit) != "in") {
    throw DataError(fmt::format("model {}: expected V in and a length out, got \"{}\" and \"{}\"", model.name,
                                model.input_unit, model.output_unit));
  }
  if (model.output_unit == "in") return model;
  const double factor = inches.factor(model.output_unit);
  return ident::in_output_unit(std::move(model), "in", factor);
}

double noise_in(const ident::Model& model, const config::RigConfig& rig, const TuneChoices& choices, double lsb_in) {
  if (choices.sheet) return choices.sheet->noise_in;
  if (const auto* sim = std::get_if<hal::SimOptions>(&rig.backend)) {
    return sim->sensor_noise_V * std::abs(sim->scale_in_per_V);
  }
  if (model.estimation && model.estimation->score.mse > 0.0) return std::sqrt(model.estimation->score.mse);
  return kLsbsOfNoise * lsb_in;
}

/// Whether [following] knows the valve better than a model's map, and does not contradict the record: the record
/// determines the map less well, or the rod moves within the map's dead band.
bool is_map_doubtful(const ident::Model& model, const config::Following& following) {
  if (!model.input_map) return false;
  switch (agreement_of(following, found_map(model))) {
    case FollowingAgreement::one_valve:
      return ident::map_shift(model).has_value();
    case FollowingAgreement::within_interval:
    case FollowingAgreement::within_map_error:
      return true;
    case FollowingAgreement::other_valve:
      break;
  }
  return false;
}

/// Greatest coefficient of a numerator.
double size_of(const ident::TransferFunction& g) {
  double size = 0.0;
  for (const ident::Term& term : g.numerator) size = std::max(size, std::abs(term.coefficient));
  return size;
}

config::PromisedFigure figure(const ident::Interval& i) {
  return {.value = i.value, .lower = i.lower, .upper = i.upper};
}

}  // namespace

TuneInputs tune_inputs(const ident::Model& given, const config::RigConfig& rig, const TuneChoices& choices) {
  const ident::Model model = in_inches(given);
  const auto* sim = std::get_if<hal::SimOptions>(&rig.backend);
  const hal::Conversion conversion = hal::conversion_of(rig.backend);
  const int bits = sim != nullptr ? sim->resolution_bits : kBitsOfACard;
  TuneInputs inputs;
  ident::AxisTask& axis = inputs.task.axis;
  axis.purpose = choices.purpose;
  axis.sensitivity = choices.sensitivity;
  axis.tick_s = choices.tick_s.value_or(rig.realtime.sample_period_s);
  axis.command_min = rig.limits.command_min_V;
  axis.command_max = rig.limits.command_max_V;
  axis.slew_per_s = rig.limits.slew_V_per_s;
  axis.lowest = rig.limits.travel_min_in;
  axis.highest = rig.limits.travel_max_in;
  axis.velocity_limit = rig.limits.velocity_limit_in_per_s;
  axis.lsb = std::abs(conversion.scale_in_per_V) * (conversion.feedback_max_V - conversion.feedback_min_V) /
             (std::exp2(bits) - 1.0);
  axis.noise = noise_in(model, rig, choices, axis.lsb);
  if (choices.sheet) {
    axis.valve = numbers_of(*choices.sheet);
    axis.valve_is_measured = true;
    inputs.task.is_one_valve =
        !model.input_map || is_of_one_valve({axis.valve->null, axis.valve->dead_band}, found_map(model));
  } else if (rig.limits.following) {
    axis.valve = numbers_of(*rig.limits.following);
    inputs.task.valve_of = ValveOrigin::following;
    axis.valve_is_measured = is_map_doubtful(model, *rig.limits.following);
  }
  inputs.task.kind = choices.kind;
  inputs.plant = ident::axis_plant(model, axis);
  // The plant is the model with a velocity gain of 1.
  inputs.model_gain_in_per_V_s = size_of(model.transfer_function) / size_of(inputs.plant.g);
  if (model.verdict && model.verdict->usable_band) inputs.lowest_Hz = model.verdict->usable_band->lowest_Hz;
  const double most_V = config::closed_loop_most_V(rig.limits);
  axis.command_min = std::max(axis.command_min, inputs.plant.valve.null - most_V);
  axis.command_max = std::min(axis.command_max, inputs.plant.valve.null + most_V);

  if (choices.twin || sim != nullptr) {
    inputs.task.twin = choices.twin ? *choices.twin : *sim;
    inputs.task.spread = spread_about_fitted(inputs.plant.valve);
    inputs.twin = choices.twin ? "named" : "the simulated rig itself";
    inputs.rig_gain_in_per_V_s = gains_of(inputs.task.twin).positive;
    inputs.rig_gain_of = choices.twin ? "the twin" : "the simulated rig";
  } else {
    hal::SimOptions base;
    base.scale_in_per_V = conversion.scale_in_per_V;
    base.offset_in = conversion.offset_in;
    base.feedback_min_V = conversion.feedback_min_V;
    base.feedback_max_V = conversion.feedback_max_V;
    base.command_min_V = conversion.command_min_V;
    base.command_max_V = conversion.command_max_V;
    base.resolution_bits = bits;
    base.stroke_mm = std::max(base.stroke_mm, kMillimetresPerInch * (axis.highest + std::max(0.0, axis.lowest)));
    inputs.task.twin = estimated_twin(inputs.plant, base);
    inputs.task.spread = spread_about_estimated(inputs.plant.valve);
    inputs.twin = "estimated from model and valve";
    if (rig.limits.following) {
      inputs.rig_gain_in_per_V_s = config::valve_estimate(*rig.limits.following).gain_positive_in_per_V_s;
      inputs.rig_gain_of = "[following] of the rig file";
    }
  }
  inputs.task.twin.sensor_noise_V = axis.noise / std::abs(inputs.task.twin.scale_in_per_V);
  return inputs;
}

config::ControllerConfig controller_of(const Tuned& tuned, const TuneInputs& inputs,
                                       config::ControllerProvenance provenance, std::string name) {
  const Promise& p = tuned.promise;
  config::ControllerConfig c;
  c.name = std::move(name);
  c.purpose = inputs.task.axis.purpose == ident::AxisPurpose::hold ? "hold" : "track";
  c.settings = tuned.design.settings;
  c.promise = {.twins = static_cast<std::int64_t>(tuned.trials.size()),
               .following_rms_in = figure(p.following_rms_in),
               .following_worst_in = figure(p.following_worst_in),
               .sine_rms_in = figure(p.sine_rms_in),
               .overshoot_in = figure(p.overshoot_in),
               .settling_s = figure(p.settling_s),
               .rest_error_in = figure(p.rest_error_in),
               .standing_in = figure(p.standing_in),
               .ms = figure(p.ms),
               .mt = figure(p.mt),
               .phase_margin_deg = figure(p.phase_margin_deg),
               .gain_margin = figure(p.gain_margin),
               .delay_margin_s = figure(p.delay_margin_s)};
  for (const std::string& sentence : tuned.remarks)
    c.promise.remarks += (c.promise.remarks.empty() ? "" : "\n") + sentence;
  c.fault = {.following_error_in = tuned.fault.following_error_in,
             .swing_V = tuned.fault.swing_V,
             .swings_per_s = tuned.fault.swings_per_s};
  c.provenance = std::move(provenance);
  return c;
}

}  // namespace eha::tune
