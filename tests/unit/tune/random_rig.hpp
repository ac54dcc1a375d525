// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

#include "hal/sim/cylinder.hpp"
#include "hal/sim/sim_options.hpp"
#include "ident/control/axis_controller.hpp"
#include "ident/control/loop_margins.hpp"
#include "ident/excitation/portable_draw.hpp"

namespace eha::tune {

/// Valve, load, friction, oil and noise drawn.
inline hal::SimOptions random_rig(ident::PortableDraw& draw) {
  const auto between = [&](double low, double high) { return low + (high - low) * draw.uniform(); };
  hal::SimOptions o;
  o.valve_dead_band_V = between(0.05, 0.4);
  o.valve_null_offset_V = between(-0.4, 0.4);
  o.valve_rated_flow_L_per_min = between(0.9, 1.8);
  o.valve_natural_frequency_Hz = between(25.0, 60.0);
  o.moving_mass_kg = between(10.0, 40.0);
  o.coulomb_friction_N = between(60.0, 200.0);
  o.static_friction_N = o.coulomb_friction_N * between(1.1, 1.6);
  o.bulk_modulus_bar = between(4000.0, 9000.0);
  o.rod_mm = between(16.0, 26.0);
  o.sensor_noise_V = between(0.0004, 0.002);
  o.seed = 1 + draw.below(1'000'000);
  while (!hal::check(o).empty()) o.sub_step_us *= 0.8;  // a light rod with much friction
  return o;
}

/// Margins of the sampled loop on the rig itself: its response to a small step of the command while the rod moves.
inline ident::LoopMargins true_margins(hal::SimOptions rig, const ident::AxisSettings& settings) {
  const double h = settings.tick_s;
  rig.initial_displacement_in = 1.5;
  const double base_V = -rig.valve_null_offset_V + rig.valve_dead_band_V + 1.0;
  const double step_V = 0.02;
  hal::Cylinder still(rig);
  hal::Cylinder moved(rig);
  still.advance(base_V, hal::Ports::open, 1.5);
  moved.advance(base_V, hal::Ports::open, 1.5);
  const auto rows = static_cast<std::size_t>(std::lround(2.0 / h));
  std::vector<double> impulse{0.0};
  double last = 0.0;
  for (std::size_t k = 0; k < rows; ++k) {
    still.advance(base_V, hal::Ports::open, h);
    moved.advance(base_V + step_V, hal::Ports::open, h);
    const double now = (moved.state().displacement_m - still.state().displacement_m) / 0.0254 / step_V;
    impulse.push_back(now - last);
    last = now;
  }
  const ident::AxisCoefficients c = ident::coefficients(settings);
  const std::vector<double> grid = ident::log_grid(0.5, std::numbers::pi / h, 150);
  std::vector<std::complex<double>> loop;
  for (const double w : grid) {
    const std::complex<double> late = std::polar(1.0, -w * h);
    std::complex<double> z = 1.0;
    std::complex<double> sum = 0.0;
    for (std::size_t k = 0; k < impulse.size(); ++k) {
      sum += (impulse[k] - (k > 0 ? impulse[k - 1] : 0.0)) * z;
      z *= late;
    }
    loop.push_back(ident::sampled_feedback(c, w) * sum / (1.0 - late) / settings.inverse.gain_positive);
  }
  return ident::loop_margins(grid, loop, 1.0 + (settings.feedback.ki > 0.0 ? 1.0 : 0.0));
}

}  // namespace eha::tune
