// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/sim/cylinder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/inch.hpp"

namespace eha::hal {
namespace {

constexpr double kPascalPerBar = 1e5;
constexpr double kGravity_m_s2 = 9.80665;

/// Below this drop an orifice turns laminar: its flow becomes proportional to the drop, and the slope at zero finite.
constexpr double kLaminarDrop_Pa = 0.2 * kPascalPerBar;

double circle_area_m2(double diameter_mm) { return std::numbers::pi / 4.0 * diameter_mm * diameter_mm * 1e-6; }

CylinderState plus(const CylinderState& a, double factor, const CylinderState& b) noexcept {
  return {a.displacement_m + factor * b.displacement_m,
          a.velocity_m_s + factor * b.velocity_m_s,
          a.cap_pressure_Pa + factor * b.cap_pressure_Pa,
          a.rod_pressure_Pa + factor * b.rod_pressure_Pa,
          a.spool_V + factor * b.spool_V,
          a.spool_rate_V_s + factor * b.spool_rate_V_s};
}

}  // namespace

Cylinder::Cylinder(const SimOptions& o) noexcept
    : cap_area_m2_(circle_area_m2(o.bore_mm)),
      rod_area_m2_(circle_area_m2(o.bore_mm) - circle_area_m2(o.rod_mm)),
      stroke_m_(o.stroke_mm * 1e-3),
      cap_dead_volume_m3_(o.cap_dead_volume_cm3 * 1e-6),
      rod_dead_volume_m3_(o.rod_dead_volume_cm3 * 1e-6),
      leakage_m3_s_Pa_(o.leakage_cm3_per_s_per_bar * 1e-6 / kPascalPerBar),
      mass_kg_(o.moving_mass_kg),
      stop_stiffness_N_m_(o.end_stop_stiffness_N_per_mm * 1e3),
      stop_damping_N_s_m_(o.end_stop_damping_N_s_per_mm * 1e3),
      coulomb_N_(o.coulomb_friction_N),
      static_N_(o.static_friction_N),
      viscous_N_s_m_(o.viscous_friction_N_s_per_mm * 1e3),
      stribeck_m_s_(o.stribeck_velocity_mm_per_s * 1e-3),
      regularisation_m_s_(o.friction_regularisation_mm_per_s * 1e-3),
      bulk_modulus_Pa_(o.bulk_modulus_bar * kPascalPerBar),
      supply_Pa_(o.supply_pressure_bar * kPascalPerBar),
      tank_Pa_(o.tank_pressure_bar * kPascalPerBar),
      full_scale_V_(o.valve_full_scale_V),
      flow_gain_m3_s_sqrtPa_(o.valve_rated_flow_L_per_min * 1e-3 / 60.0 /
                             std::sqrt(o.valve_rated_drop_bar * kPascalPerBar)),
      spool_rad_s_(2.0 * std::numbers::pi * o.valve_natural_frequency_Hz),
      spool_damping_(o.valve_damping_ratio),
      dead_band_V_(o.valve_dead_band_V),
      null_offset_V_(o.valve_null_offset_V),
      sub_step_s_(o.sub_step_us * 1e-6) {
  state_.displacement_m = o.initial_displacement_in * kMetrePerInch;
  state_.cap_pressure_Pa = mass_kg_ * kGravity_m_s2 / (cap_area_m2_ - rod_area_m2_);
  state_.rod_pressure_Pa = state_.cap_pressure_Pa;
}

double Cylinder::opening(double spool_V) const noexcept {
  return std::clamp((std::abs(spool_V) - dead_band_V_) / (full_scale_V_ - dead_band_V_), 0.0, 1.0);
}

double Cylinder::edge_flow(double opening, double drop_Pa) const noexcept {
  return opening * flow_gain_m3_s_sqrtPa_ * drop_Pa /
         std::sqrt(std::sqrt(drop_Pa * drop_Pa + kLaminarDrop_Pa * kLaminarDrop_Pa));
}

double Cylinder::friction(double v) const noexcept {
  const double relative = v / stribeck_m_s_;
  const double dry = coulomb_N_ + (static_N_ - coulomb_N_) / (1.0 + relative * relative);
  return dry * v / std::sqrt(v * v + regularisation_m_s_ * regularisation_m_s_) + viscous_N_s_m_ * v;
}

double Cylinder::end_stop(double x, double v) const noexcept {
  // A cushion pushes and never pulls.
  if (x < 0.0) return std::min(0.0, stop_stiffness_N_m_ * x + stop_damping_N_s_m_ * v);
  if (x > stroke_m_) return std::max(0.0, stop_stiffness_N_m_ * (x - stroke_m_) + stop_damping_N_s_m_ * v);
  return 0.0;
}

CylinderState Cylinder::derivative(const CylinderState& s, double spool_target_V, Ports ports) const noexcept {
  double cap_flow = 0.0;
  double rod_flow = 0.0;
  if (ports == Ports::open) {
    const double open = opening(s.spool_V);
    if (open > 0.0) {
      if (s.spool_V > 0.0) {
        cap_flow = edge_flow(open, supply_Pa_ - s.cap_pressure_Pa);
        rod_flow = -edge_flow(open, s.rod_pressure_Pa - tank_Pa_);
      } else {
        cap_flow = -edge_flow(open, s.cap_pressure_Pa - tank_Pa_);
        rod_flow = edge_flow(open, supply_Pa_ - s.rod_pressure_Pa);
      }
    }
  }
  const double leakage = leakage_m3_s_Pa_ * (s.cap_pressure_Pa - s.rod_pressure_Pa);
  const double cap_volume = cap_dead_volume_m3_ + cap_area_m2_ * s.displacement_m;
  const double rod_volume = rod_dead_volume_m3_ + rod_area_m2_ * (stroke_m_ - s.displacement_m);
  const double force = s.cap_pressure_Pa * cap_area_m2_ - s.rod_pressure_Pa * rod_area_m2_ - friction(s.velocity_m_s) -
                       end_stop(s.displacement_m, s.velocity_m_s);
  CylinderState d;
  d.displacement_m = s.velocity_m_s;
  d.velocity_m_s = force / mass_kg_ - kGravity_m_s2;
  d.cap_pressure_Pa = bulk_modulus_Pa_ / cap_volume * (cap_flow - cap_area_m2_ * s.velocity_m_s - leakage);
  d.rod_pressure_Pa = bulk_modulus_Pa_ / rod_volume * (rod_flow + rod_area_m2_ * s.velocity_m_s + leakage);
  d.spool_V = s.spool_rate_V_s;
  d.spool_rate_V_s =
      spool_rad_s_ * (spool_rad_s_ * (spool_target_V - s.spool_V) - 2.0 * spool_damping_ * s.spool_rate_V_s);
  return d;
}

void Cylinder::advance(double command_V, Ports ports, double duration_s) noexcept {
  if (!(duration_s > 0.0)) return;
  // The tolerance keeps a duration of whole sub-steps from being cut into one more by rounding.
  const auto steps = std::max<std::int64_t>(1, std::llround(std::ceil(duration_s / sub_step_s_ * (1.0 - 1e-9))));
  const double h = duration_s / static_cast<double>(steps);
  const double target_V = ports == Ports::open ? command_V + null_offset_V_ : 0.0;
  for (std::int64_t i = 0; i < steps; ++i) {
    const CylinderState k1 = derivative(state_, target_V, ports);
    const CylinderState k2 = derivative(plus(state_, 0.5 * h, k1), target_V, ports);
    const CylinderState k3 = derivative(plus(state_, 0.5 * h, k2), target_V, ports);
    const CylinderState k4 = derivative(plus(state_, h, k3), target_V, ports);
    state_ = plus(plus(plus(plus(state_, h / 6.0, k1), h / 3.0, k2), h / 3.0, k3), h / 6.0, k4);
    state_.cap_pressure_Pa = std::max(state_.cap_pressure_Pa, 0.0);
    state_.rod_pressure_Pa = std::max(state_.rod_pressure_Pa, 0.0);
  }
}

CylinderState Cylinder::implicit(const CylinderState& f, const CylinderState& at, double g,
                                 Ports ports) const noexcept {
  // Slope of an edge's flow over its drop; the method keeps its order with an approximate Jacobian.
  double cap_slope = leakage_m3_s_Pa_;
  double rod_slope = leakage_m3_s_Pa_;
  if (const double open = ports == Ports::open ? opening(at.spool_V) : 0.0; open > 0.0) {
    const bool extends = at.spool_V > 0.0;
    const double cap_drop = extends ? supply_Pa_ - at.cap_pressure_Pa : at.cap_pressure_Pa - tank_Pa_;
    const double rod_drop = extends ? at.rod_pressure_Pa - tank_Pa_ : supply_Pa_ - at.rod_pressure_Pa;
    const double gain = 0.5 * open * flow_gain_m3_s_sqrtPa_;
    cap_slope += gain / std::sqrt(std::abs(cap_drop) + kLaminarDrop_Pa);
    rod_slope += gain / std::sqrt(std::abs(rod_drop) + kLaminarDrop_Pa);
  }
  const double v = at.velocity_m_s;
  const double width = v * v + regularisation_m_s_ * regularisation_m_s_;
  const double relative = v / stribeck_m_s_;
  const double dry = coulomb_N_ + (static_N_ - coulomb_N_) / (1.0 + relative * relative);
  const bool is_at_stop = at.displacement_m < 0.0 || at.displacement_m > stroke_m_;
  const double drag = dry * regularisation_m_s_ * regularisation_m_s_ / (width * std::sqrt(width)) + viscous_N_s_m_ +
                      (is_at_stop ? stop_damping_N_s_m_ : 0.0);
  const double stop = is_at_stop ? stop_stiffness_N_m_ : 0.0;
  const double cap_rate = bulk_modulus_Pa_ / (cap_dead_volume_m3_ + cap_area_m2_ * at.displacement_m);
  const double rod_rate = bulk_modulus_Pa_ / (rod_dead_volume_m3_ + rod_area_m2_ * (stroke_m_ - at.displacement_m));
  const double cap_self = 1.0 + g * cap_rate * cap_slope;
  const double rod_self = 1.0 + g * rod_rate * rod_slope;
  // Pressures and position are eliminated: one equation for the velocity is left.
  const double cap_push = g * cap_area_m2_ / cap_self;
  const double rod_push = g * rod_area_m2_ / rod_self;
  CylinderState k = f;
  k.velocity_m_s =
      (mass_kg_ * f.velocity_m_s - g * stop * f.displacement_m + cap_push * f.cap_pressure_Pa -
       rod_push * f.rod_pressure_Pa) /
      (mass_kg_ + g * drag + g * (g * stop + cap_push * cap_rate * cap_area_m2_ + rod_push * rod_rate * rod_area_m2_));
  k.displacement_m = f.displacement_m + g * k.velocity_m_s;
  k.cap_pressure_Pa = (f.cap_pressure_Pa - g * cap_rate * cap_area_m2_ * k.velocity_m_s) / cap_self;
  k.rod_pressure_Pa = (f.rod_pressure_Pa + g * rod_rate * rod_area_m2_ * k.velocity_m_s) / rod_self;
  return k;
}

void Cylinder::advance_implicitly(double command_V, Ports ports, double duration_s, double step_s) noexcept {
  if (!(duration_s > 0.0)) return;
  const auto steps = std::max<std::int64_t>(1, std::llround(std::ceil(duration_s / step_s * (1.0 - 1e-9))));
  const double h = duration_s / static_cast<double>(steps);
  const double g = (1.0 - 0.5 * std::numbers::sqrt2) * h;
  const double target_V = ports == Ports::open ? command_V + null_offset_V_ : 0.0;
  for (std::int64_t i = 0; i < steps; ++i) {
    const CylinderState at = state_;
    const CylinderState k1 = implicit(derivative(at, target_V, ports), at, g, ports);
    const CylinderState k2 = implicit(plus(derivative(plus(at, h, k1), target_V, ports), -2.0, k1), at, g, ports);
    state_ = plus(plus(at, 1.5 * h, k1), 0.5 * h, k2);
    state_.cap_pressure_Pa = std::max(state_.cap_pressure_Pa, 0.0);
    state_.rod_pressure_Pa = std::max(state_.rod_pressure_Pa, 0.0);
  }
}

}  // namespace eha::hal
