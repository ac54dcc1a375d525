// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/sim/sim_options.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "core/millimetre_key.hpp"

namespace eha::hal {
namespace {

/// Largest accepted product of sub-step and fastest rate. Classical Runge-Kutta is stable up to 2.78 on the negative
/// real axis; the test of convergence pins the accuracy at the shipped 1.0.
constexpr double kLargestStepTimesRate = 1.5;

class Checker {
 public:
  std::vector<OptionIssue> issues;

  void issue(const char* key, const char* expected, double value) {
    std::ostringstream text;
    text << "expected " << expected << ", got " << value;
    issues.push_back({key, text.str()});
  }
  void positive(const char* key, double value) {
    if (!(value > 0.0 && std::isfinite(value))) issue(key, "a number greater than 0", value);
  }
  void not_negative(const char* key, double value) {
    if (!(value >= 0.0 && std::isfinite(value))) issue(key, "a number not below 0", value);
  }
  void finite(const char* key, double value) {
    if (!std::isfinite(value)) issue(key, "a finite number", value);
  }
  void below(const char* key, double value, const char* limit_key, double limit) {
    if (!(value < limit)) {
      std::ostringstream expected;
      expected << "less than " << limit_key << " = " << limit;
      issue(key, expected.str().c_str(), value);
    }
  }
};

/// Fastest rate of the model's linearised dynamics [1/s], from above.
double fastest_rate_per_s(const SimOptions& o) {
  const double cap_area_m2 = std::numbers::pi / 4.0 * o.bore_mm * o.bore_mm * 1e-6;
  const double dead_volume_m3 = std::min(o.cap_dead_volume_cm3, o.rod_dead_volume_cm3) * 1e-6;
  const double bulk_modulus_Pa = o.bulk_modulus_bar * 1e5;
  const double friction_N_s_m =
      o.static_friction_N / (o.friction_regularisation_mm_per_s * 1e-3) + o.viscous_friction_N_s_per_mm * 1e3;
  const double damping = (friction_N_s_m + o.end_stop_damping_N_s_per_mm * 1e3) / o.moving_mass_kg;
  const double stiffness_N_m =
      2.0 * bulk_modulus_Pa * cap_area_m2 * cap_area_m2 / dead_volume_m3 + o.end_stop_stiffness_N_per_mm * 1e3;
  const double oscillation = std::sqrt(stiffness_N_m / o.moving_mass_kg);
  const double spool =
      2.0 * std::numbers::pi * o.valve_natural_frequency_Hz * std::max(1.0, 2.0 * o.valve_damping_ratio);
  return std::max({damping, oscillation, spool});
}

}  // namespace

std::vector<OptionIssue> check(const SimOptions& o) {
  Checker c;
  c.positive("bore_mm", o.bore_mm);
  c.positive("rod_mm", o.rod_mm);
  if (o.rod_mm > 0.0) c.below("rod_mm", o.rod_mm, "bore_mm", o.bore_mm);
  c.positive("stroke_mm", o.stroke_mm);
  if (!(o.initial_displacement_in >= 0.0 && o.initial_displacement_in * kMillimetresPerInch <= o.stroke_mm)) {
    c.issue("initial_displacement_in", "from 0 to the stroke", o.initial_displacement_in);
  }
  c.positive("cap_dead_volume_cm3", o.cap_dead_volume_cm3);
  c.positive("rod_dead_volume_cm3", o.rod_dead_volume_cm3);
  c.not_negative("leakage_cm3_per_s_per_bar", o.leakage_cm3_per_s_per_bar);
  c.positive("moving_mass_kg", o.moving_mass_kg);
  c.positive("end_stop_stiffness_N_per_mm", o.end_stop_stiffness_N_per_mm);
  c.not_negative("end_stop_damping_N_s_per_mm", o.end_stop_damping_N_s_per_mm);
  c.not_negative("coulomb_friction_N", o.coulomb_friction_N);
  c.not_negative("static_friction_N", o.static_friction_N);
  if (o.static_friction_N < o.coulomb_friction_N) {
    c.issue("static_friction_N", "not below coulomb_friction_N", o.static_friction_N);
  }
  c.not_negative("viscous_friction_N_s_per_mm", o.viscous_friction_N_s_per_mm);
  c.positive("stribeck_velocity_mm_per_s", o.stribeck_velocity_mm_per_s);
  c.positive("friction_regularisation_mm_per_s", o.friction_regularisation_mm_per_s);
  c.positive("bulk_modulus_bar", o.bulk_modulus_bar);
  c.positive("supply_pressure_bar", o.supply_pressure_bar);
  c.not_negative("tank_pressure_bar", o.tank_pressure_bar);
  if (o.supply_pressure_bar > 0.0) {
    c.below("tank_pressure_bar", o.tank_pressure_bar, "supply_pressure_bar", o.supply_pressure_bar);
  }
  c.positive("valve_full_scale_V", o.valve_full_scale_V);
  c.positive("valve_rated_flow_L_per_min", o.valve_rated_flow_L_per_min);
  c.positive("valve_rated_drop_bar", o.valve_rated_drop_bar);
  c.positive("valve_natural_frequency_Hz", o.valve_natural_frequency_Hz);
  c.positive("valve_damping_ratio", o.valve_damping_ratio);
  c.not_negative("valve_dead_band_V", o.valve_dead_band_V);
  if (o.valve_full_scale_V > 0.0) {
    c.below("valve_dead_band_V", o.valve_dead_band_V, "valve_full_scale_V", o.valve_full_scale_V);
  }
  c.finite("valve_null_offset_V", o.valve_null_offset_V);
  c.finite("command_max_V", o.command_max_V);
  c.below("command_min_V", o.command_min_V, "command_max_V", o.command_max_V);
  c.finite("feedback_max_V", o.feedback_max_V);
  c.below("feedback_min_V", o.feedback_min_V, "feedback_max_V", o.feedback_max_V);
  if (o.resolution_bits < 8 || o.resolution_bits > 24) c.issue("resolution_bits", "from 8 to 24", o.resolution_bits);
  if (!std::isfinite(o.scale_in_per_V) || std::abs(o.scale_in_per_V) < 1e-9) {
    c.issue("scale_in_per_V", "a number that is not 0", o.scale_in_per_V);
  }
  c.finite("offset_in", o.offset_in);
  c.not_negative("sensor_noise_V", o.sensor_noise_V);
  // Shorter ones make a tick that does not end.
  if (!(o.sub_step_us >= 0.1)) c.issue("sub_step_us", "a number of at least 0.1", o.sub_step_us);
  if (c.issues.empty()) {
    const double longest_us = kLargestStepTimesRate / fastest_rate_per_s(o) * 1e6;
    if (o.sub_step_us > longest_us) {
      std::ostringstream expected;
      expected << "at most " << longest_us << " for this stiffness, friction and mass";
      c.issue("sub_step_us", expected.str().c_str(), o.sub_step_us);
    }
  }
  return c.issues;
}

}  // namespace eha::hal
