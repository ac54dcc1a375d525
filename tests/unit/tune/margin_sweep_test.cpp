// SPDX-License-Identifier: GPL-3.0-or-later
// The margins that a sweep in closed loop measures, against those of the simulated rig's own response. 50 rigs.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "config/rig_config.hpp"
#include "daemon/tune/tune_inputs.hpp"
#include "hal/converter.hpp"
#include "hal/sim/normal_noise.hpp"
#include "ident/control/margin_sweep.hpp"
#include "ident/control/trial.hpp"
#include "tests/unit/tune/random_rig.hpp"

namespace eha::tune {
namespace {

constexpr double kInch_m = 0.0254;

/// A controller for a rig whose valve and lag are known to a few percent.
ident::AxisSettings controller_for(const hal::SimOptions& truth, double tick_s, ident::PortableDraw& draw) {
  const auto about = [&](double value, double share) { return value * (1.0 + share * (2.0 * draw.uniform() - 1.0)); };
  config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  rig.realtime.sample_period_s = tick_s;
  rig.backend = truth;
  const TwinGains gains = gains_of(truth);
  ident::Model model;
  model.name = "rod";
  model.input_unit = "V";
  model.output_unit = "in";
  model.input_map = ident::ValveMap{-truth.valve_null_offset_V, about(truth.valve_dead_band_V, 0.03),
                                    gains.negative / gains.positive};
  model.transfer_function = {{{about(gains.positive, 0.02), 0}}, {{about(0.0065, 0.2), 2}, {1, 1}}, 0.0};
  model.initial_output = 2.95;
  TuneInputs inputs = tune_inputs(model, rig, {});
  inputs.task.twins = 4;
  inputs.task.hold_s = 4.0;
  inputs.task.axis.draws = 40;
  return tune(inputs.plant, inputs.task).design.settings;
}

/// The sweep on a rig with noise and converters, as a trial plays it. @returns the least of both directions
ident::MeasuredMargins swept(hal::SimOptions rig, const ident::AxisSettings& settings) {
  ident::TrialPlan plan = ident::trial_plan(settings);
  plan.trapezoids = 0;
  plan.sweep = ident::margin_sweep(settings, plan.step, 0.05);
  const ident::MarginSweep& sweep = *plan.sweep;
  rig.initial_displacement_in = 2.0;
  hal::Cylinder cylinder(rig);
  hal::Converter output(rig.command_min_V, rig.command_max_V, rig.resolution_bits);
  hal::Converter input(rig.feedback_min_V, rig.feedback_max_V, rig.resolution_bits);
  hal::NormalNoise noise(rig.seed);
  const auto read_in = [&] {
    const double volts = (cylinder.state().displacement_m / kInch_m - rig.offset_in) / rig.scale_in_per_V;
    return rig.offset_in +
           rig.scale_in_per_V * input.volts(input.code(volts + rig.sensor_noise_V * noise()));
  };
  const double home_in = read_in();
  const ident::TrialMotion motion(settings, plan, home_in);
  ident::AxisController controller(ident::coefficients(settings));
  controller.start(home_in, settings.inverse.null);
  std::vector<double> rod;
  std::vector<double> injected;
  for (std::size_t row = 1; row < motion.rows(); ++row) {
    const double reading_in = read_in();
    const ident::AxisOutput out = controller.step(motion.set_point(row), reading_in - motion.injected(row));
    if (motion.part(row) == ident::TrialMotion::Part::sweep) {
      rod.push_back(reading_in);
      injected.push_back(motion.injected(row));
    } else if (!rod.empty()) {
      break;
    }
    cylinder.advance(output.volts(output.code(out.command)), hal::Ports::open, settings.tick_s);
  }
  std::vector<ident::SweepWay> ways;
  // The true margins are those of extending.
  const std::size_t extending = motion.way() > 0.0 ? 0 : 1;
  for (std::size_t way = extending; way < sweep.ways; way += 2) {
    const std::size_t begin = way * sweep.way_rows() + sweep.lead_rows;
    ways.push_back({std::span(injected).subspan(begin, sweep.measured_rows()),
                    std::span(rod).subspan(begin, sweep.measured_rows())});
  }
  return ident::measured_margins(sweep, settings, ways);
}

TEST(MarginSweep, MeasuresTheRigsOwnMargins) {
  double worst_deg = 0.0;
  for (int i = 0; i < 50; ++i) {
    ident::PortableDraw draw(3000 + static_cast<std::uint64_t>(i));
    const hal::SimOptions truth = random_rig(draw);
    const double tick_s = std::vector{0.001, 0.002, 0.004}[draw.below(3)];
    const ident::AxisSettings settings = controller_for(truth, tick_s, draw);
    const ident::LoopMargins own = true_margins(truth, settings);
    const ident::MeasuredMargins measured = swept(truth, settings);
    const std::string which =
        fmt::format("rig {}, tick {:g} s, kp {:.1f}: own {:.1f} deg, Ms {:.3f}, {:.4f} s; measured {:.1f} +- {:.1f} "
                    "deg, {:.3f} +- {:.3f}, {:.4f} +- {:.4f} s",
                    i, tick_s, settings.feedback.kp, own.phase_deg, own.ms, own.delay_s, measured.margins.phase_deg,
                    measured.phase_std_deg, measured.margins.ms, measured.ms_std, measured.margins.delay_s,
                    measured.delay_std_s);
    if (std::getenv("EHA_SWEEP_SHOWS") != nullptr) fmt::print("{}\n", which);
    ASSERT_TRUE(own.is_stable && measured.margins.is_stable) << which;
    EXPECT_NEAR(measured.margins.phase_deg, own.phase_deg, 3.0) << which;
    EXPECT_NEAR(measured.margins.ms, own.ms, 0.1 * own.ms) << which;
    worst_deg = std::max(worst_deg, std::abs(measured.margins.phase_deg - own.phase_deg));
  }
  RecordProperty("worst_deg", fmt::format("{:.2f}", worst_deg));
  fmt::print("worst {:.2f} deg\n", worst_deg);
}

}  // namespace
}  // namespace eha::tune
