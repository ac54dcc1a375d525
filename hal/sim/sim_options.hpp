// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/keys.hpp"
#include "core/option_issue.hpp"
#include "hal/conversion.hpp"

namespace eha::hal {

/// Physical parameters of the simulated actuator: a vertical single-ended cylinder, rod upwards, on a
/// proportional valve, as shipped in config/rigs/sim.toml. Each member is a key of `[sim]` with the same name.
/// Positive volts extend the rod.
struct SimOptions {
  static constexpr std::string_view kName = "sim";
  static constexpr bool kMovesMachine = false;
  static constexpr bool kHasVirtualClock = true;

  // Cylinder. Bore and rod give the area ratio bore^2 / (bore^2 - rod^2) = 1.33.
  double bore_mm = 40.0;                      ///< piston diameter [mm]
  double rod_mm = 20.0;                       ///< rod diameter, smaller than the bore [mm]
  double stroke_mm = 150.0;                   ///< travel between the end stops [mm]
  double initial_displacement_in = 2.95;      ///< rod position when the rig is opened, 0 is fully retracted [in]
  double cap_dead_volume_cm3 = 25.0;          ///< oil between valve and retracted piston, cap side [cm^3]
  double rod_dead_volume_cm3 = 20.0;          ///< oil between valve and extended piston, rod side [cm^3]
  double leakage_cm3_per_s_per_bar = 0.004;   ///< flow past the piston seal, laminar [cm^3/(s bar)]
  double moving_mass_kg = 20.0;               ///< rod, piston and load [kg]
  double end_stop_stiffness_N_per_mm = 1e5;   ///< of the cushion at each end of the stroke [N/mm]
  double end_stop_damping_N_s_per_mm = 40.0;  ///< of the cushion, acts only while it is compressed [N s/mm]

  // Friction: F(v) = (coulomb + (static - coulomb) / (1 + (v/stribeck)^2)) v/sqrt(v^2 + regularisation^2) + viscous v.
  double coulomb_friction_N = 120.0;              ///< sliding friction [N]
  double static_friction_N = 180.0;               ///< break-away friction, not below the sliding one [N]
  double viscous_friction_N_s_per_mm = 6.0;       ///< [N s/mm]
  double stribeck_velocity_mm_per_s = 1.0;        ///< speed at which half of the break-away excess is gone [mm/s]
  double friction_regularisation_mm_per_s = 0.5;  ///< below it dry friction is steep viscous friction [mm/s]

  // Oil and supply.
  double bulk_modulus_bar = 7000.0;   ///< effective, air and hoses included [bar]
  double supply_pressure_bar = 70.0;  ///< held constant by the pump [bar]
  double tank_pressure_bar = 2.0;     ///< back pressure of the return line [bar]

  // Proportional valve: each edge passes rated flow x opening x sqrt(drop / rated drop).
  double valve_full_scale_V = 5.0;           ///< command at which the spool is fully open [V]
  double valve_rated_flow_L_per_min = 1.2;   ///< through one edge, fully open, at the rated drop [L/min]
  double valve_rated_drop_bar = 35.0;        ///< pressure drop over one edge at the rated flow [bar]
  double valve_natural_frequency_Hz = 40.0;  ///< of the spool [Hz]
  double valve_damping_ratio = 0.8;          ///< of the spool, 1 is critical
  double valve_dead_band_V = 0.15;           ///< half width: the spool's overlap to either side of its null [V]
  double valve_null_offset_V = 0.2;          ///< the spool is at its null when the command is minus this [V]

  // Converters and sensor. displacement_in = offset_in + scale_in_per_V * feedback_V.
  double command_min_V = -10.0;  ///< range of the output converter [V]
  double command_max_V = 10.0;
  double feedback_min_V = -10.0;  ///< range of the input converter [V]
  double feedback_max_V = 10.0;
  int resolution_bits = 16;       ///< of both converters, 8..24
  double scale_in_per_V = 0.6;    ///< wire sensor [in/V]
  double offset_in = 0.0;         ///< displacement at 0 V [in]
  double sensor_noise_V = 0.001;  ///< standard deviation, white and Gaussian [V]
  std::uint64_t seed = 1;         ///< of the sensor noise

  double sub_step_us = 50.0;  ///< longest integration step [us]

  bool operator==(const SimOptions&) const = default;

  /// check() defines the sensible values.
  static void visit_keys(auto& self, auto& keys) {
    const auto number = [&](std::string_view key, auto& value) {
      keys.number(key, value, Range::any(), Need::optional);
    };
    number("bore_mm", self.bore_mm);
    number("rod_mm", self.rod_mm);
    number("stroke_mm", self.stroke_mm);
    number("initial_displacement_in", self.initial_displacement_in);
    number("cap_dead_volume_cm3", self.cap_dead_volume_cm3);
    number("rod_dead_volume_cm3", self.rod_dead_volume_cm3);
    number("leakage_cm3_per_s_per_bar", self.leakage_cm3_per_s_per_bar);
    number("moving_mass_kg", self.moving_mass_kg);
    number("end_stop_stiffness_N_per_mm", self.end_stop_stiffness_N_per_mm);
    number("end_stop_damping_N_s_per_mm", self.end_stop_damping_N_s_per_mm);
    number("coulomb_friction_N", self.coulomb_friction_N);
    number("static_friction_N", self.static_friction_N);
    number("viscous_friction_N_s_per_mm", self.viscous_friction_N_s_per_mm);
    number("stribeck_velocity_mm_per_s", self.stribeck_velocity_mm_per_s);
    number("friction_regularisation_mm_per_s", self.friction_regularisation_mm_per_s);
    number("bulk_modulus_bar", self.bulk_modulus_bar);
    number("supply_pressure_bar", self.supply_pressure_bar);
    number("tank_pressure_bar", self.tank_pressure_bar);
    number("valve_full_scale_V", self.valve_full_scale_V);
    number("valve_rated_flow_L_per_min", self.valve_rated_flow_L_per_min);
    number("valve_rated_drop_bar", self.valve_rated_drop_bar);
    number("valve_natural_frequency_Hz", self.valve_natural_frequency_Hz);
    number("valve_damping_ratio", self.valve_damping_ratio);
    number("valve_dead_band_V", self.valve_dead_band_V);
    number("valve_null_offset_V", self.valve_null_offset_V);
    number("command_min_V", self.command_min_V);
    number("command_max_V", self.command_max_V);
    number("feedback_min_V", self.feedback_min_V);
    number("feedback_max_V", self.feedback_max_V);
    number("scale_in_per_V", self.scale_in_per_V);
    number("offset_in", self.offset_in);
    number("sensor_noise_V", self.sensor_noise_V);
    number("sub_step_us", self.sub_step_us);
    keys.integer("resolution_bits", self.resolution_bits, 8, 24, Need::optional);
    keys.integer("seed", self.seed, 0, std::numeric_limits<std::int64_t>::max(), Need::optional);
  }

  [[nodiscard]] std::string describe() const { return "simulated"; }
  [[nodiscard]] Conversion conversion() const {
    return {.command_min_V = command_min_V,
            .command_max_V = command_max_V,
            .feedback_min_V = feedback_min_V,
            .feedback_max_V = feedback_max_V,
            .scale_in_per_V = scale_in_per_V,
            .offset_in = offset_in,
            .calibration_date = {}};
  }
};

/// Returns every parameter that makes no physical sense or that the integration cannot follow; empty if there is none.
[[nodiscard]] std::vector<OptionIssue> check(const SimOptions& options);

}  // namespace eha::hal
