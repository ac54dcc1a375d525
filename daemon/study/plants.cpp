// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/study/plants.hpp"

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/millimetre_key.hpp"
#include "daemon/replay/replay.hpp"
#include "hal/sim/sim_options.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "ident/model/model_output.hpp"

namespace eha::study {
namespace {

constexpr double kStep_s = 0.001;
constexpr Eigen::Index kRows = 50'000;
constexpr double kSpread = 0.2;  // of a parameter, to both sides
constexpr double kStart_in = 2.95;
// The sensor of the shipped rig: 1 mV of noise and 16 bits over 20 V at 0.6 in/V.
constexpr double kNoise_in = 6e-4;
constexpr double kCode_in = 12.0 / 65536.0;
// A rod this near an end stop has saturated samples, which carry no information.
constexpr double kEndMargin_in = 0.05;
constexpr int kMostDraws = 100;

/// The tones of config/experiments/paper.toml [V].
Eigen::VectorXd paper_tones() {
  Eigen::VectorXd volts(kRows);
  for (Eigen::Index k = 0; k < kRows; ++k) {
    const double turn = 2.0 * std::numbers::pi * kStep_s * static_cast<double>(k);
    volts[k] =
        -0.1 + 1.9 * std::cos(0.05 * turn + 1.8) + 1.6 * std::cos(0.2 * turn + 1.9) + 1.5 * std::cos(0.65 * turn + 4.2);
  }
  return volts;
}

double varied(double value, ident::PortableDraw& draw) {
  return value * (1.0 + kSpread * (2.0 * draw.uniform() - 1.0));
}

/// @param friction  factor on dry friction
ident::Record rig_record(std::uint64_t seed, double friction) {
  ident::PortableDraw draw(seed);
  const Eigen::VectorXd volts = paper_tones();
  for (int drawn = 0; drawn < kMostDraws; ++drawn) {
    hal::SimOptions options;
    options.seed = seed;
    for (double* value : {&options.valve_null_offset_V, &options.valve_dead_band_V, &options.supply_pressure_bar,
                          &options.moving_mass_kg, &options.viscous_friction_N_s_per_mm}) {
      *value = varied(*value, draw);
    }
    const double dry = varied(friction, draw);
    options.coulomb_friction_N *= dry;
    options.static_friction_N *= dry;
    ident::Record record = replay::recorded(options, volts, kStep_s, options.seed);
    const double end_in = options.stroke_mm / kMillimetresPerInch - kEndMargin_in;
    if (record.output.minCoeff() > kEndMargin_in && record.output.maxCoeff() < end_in) return record;
  }
  throw DataError("study: every drawn rig reaches an end stop");
}

ident::Record linear_record(std::uint64_t seed, const ident::TransferFunction& nominal) {
  ident::PortableDraw draw(seed);
  ident::Model plant;
  plant.transfer_function = nominal;
  for (ident::Term& term : plant.transfer_function.numerator) term.coefficient = varied(term.coefficient, draw);
  for (ident::Term& term : plant.transfer_function.denominator) term.coefficient = varied(term.coefficient, draw);
  plant.input_bias = varied(0.2, draw);
  plant.initial_output = kStart_in;
  ident::Record record{.step_s = kStep_s, .input = paper_tones(), .output = {}};
  record.output = ident::simulate(plant, record.input, kStep_s, ident::SimulationMethod::exact);
  for (double& y : record.output) y = std::round((y + kNoise_in * draw.normal()) / kCode_in) * kCode_in;
  return record;
}

ident::Record with_friction(std::uint64_t seed) { return rig_record(seed, 1.0); }
ident::Record without_friction(std::uint64_t seed) { return rig_record(seed, 0.0); }
ident::Record integer_order(std::uint64_t seed) {
  return linear_record(seed, {{{0.13, 0.0}}, {{0.05, 2.0}, {1.0, 1.0}, {0.04, 0.0}}, 0.0});
}
ident::Record fractional_order(std::uint64_t seed) {
  return linear_record(seed, {{{0.15, 0.0}}, {{0.6, 1.75}, {1.0, 0.9}, {0.04, 0.0}}, 0.0});
}

}  // namespace

const std::array<PlantKind, 4>& plant_kinds() {
  static const std::array<PlantKind, 4> kinds{
      PlantKind{.name = "rig_with_friction",
                .title = "Rig with friction",
                .what = "The shipped simulated rig: valve with dead band and null, dry friction, gravity.",
                .true_order = {},
                .record = with_friction},
      PlantKind{.name = "rig_without_friction",
                .title = "Rig without friction",
                .what = "The same without dry friction.",
                .true_order = {},
                .record = without_friction},
      PlantKind{.name = "integer_order",
                .title = "Plant of integer order",
                .what = "0.13 / (0.05 s^2 + s + 0.04) behind an input bias of 0.2 V.",
                .true_order = 2.0,
                .record = integer_order},
      PlantKind{.name = "fractional_order",
                .title = "Plant of fractional order",
                .what = "0.15 / (0.6 s^1.75 + s^0.9 + 0.04) behind an input bias of 0.2 V.",
                .true_order = 1.75,
                .record = fractional_order}};
  return kinds;
}

}  // namespace eha::study
