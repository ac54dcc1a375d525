// SPDX-License-Identifier: GPL-3.0-or-later
// The margins that a sweep in closed loop measures, against those of the simulated rig's own response. 50 rigs.
#include "ident/control/margin_sweep.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <string>
#include <vector>

#include "config/rig_config.hpp"
#include "daemon/tune/tune_inputs.hpp"
#include "hal/converter.hpp"
#include "hal/sim/normal_noise.hpp"
#include "ident/control/trial.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/structure/structures.hpp"
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
    return rig.offset_in + rig.scale_in_per_V * input.volts(input.code(volts + rig.sensor_noise_V * noise()));
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

/// How many to draw. @param name  of the environment variable that asks for more, as a campaign does
int drawn(const char* name, int usual) {
  const char* asked = std::getenv(name);
  return asked != nullptr ? std::atoi(asked) : usual;
}

/// EHA_SWEEP_RIGS: how many rigs instead of 3; docs/axis.md speaks of 50.
TEST(MarginSweep, MeasuresTheRigsOwnMargins) {
  const int rigs = drawn("EHA_SWEEP_RIGS", 3);
  double worst_deg = 0.0;
  for (int i = 0; i < rigs; ++i) {
    ident::PortableDraw draw(3000 + static_cast<std::uint64_t>(i));
    const hal::SimOptions truth = random_rig(draw);
    const double tick_s = std::vector{0.001, 0.002, 0.004}[draw.below(3)];
    const ident::AxisSettings settings = controller_for(truth, tick_s, draw);
    const ident::LoopMargins own = true_margins(truth, settings);
    const ident::MeasuredMargins measured = swept(truth, settings);
    const std::string which = fmt::format(
        "rig {}, tick {:g} s, kp {:.1f}: own {:.1f} deg, Ms {:.3f}, {:.4f} s; measured {:.1f} +- {:.1f} "
        "deg, {:.3f} +- {:.3f}, {:.4f} +- {:.4f} s",
        i, tick_s, settings.feedback.kp, own.phase_deg, own.ms, own.delay_s, measured.margins.phase_deg,
        measured.phase_std_deg, measured.margins.ms, measured.ms_std, measured.margins.delay_s, measured.delay_std_s);
    if (std::getenv("EHA_SWEEP_SHOWS") != nullptr) fmt::print("{}\n", which);
    ASSERT_TRUE(own.is_stable && measured.margins.is_stable) << which;
    EXPECT_NEAR(measured.margins.phase_deg, own.phase_deg, 3.0) << which;
    EXPECT_NEAR(measured.margins.ms, own.ms, 0.15 * own.ms) << which;
    EXPECT_NEAR(measured.margins.mt, own.mt, 0.15 * own.mt) << which;
    worst_deg = std::max(worst_deg, std::abs(measured.margins.phase_deg - own.phase_deg));
  }
  RecordProperty("worst_deg", fmt::format("{:.2f}", worst_deg));
  fmt::print("worst {:.2f} deg\n", worst_deg);
}

/// An integrator with a lag behind a valve that the controller knows but for a part of its gain, a sensor with white
/// noise and a load that wanders: what a direct fit takes for the plant.
struct Twin {
  double gain_share = 1.0;
  double lag_s = 0.006;
  double noise_in = 6e-4;
  double load_in_per_s = 4e-3;  ///< standard deviation of the speed that the load causes
};

/// One whose gain and lag are not what the controller knows.
Twin drawn_twin(int i) {
  ident::PortableDraw draw(9000 + static_cast<std::uint64_t>(i));
  Twin twin;
  twin.gain_share = 0.85 + 0.3 * draw.uniform();
  twin.lag_s = 0.004 + 0.006 * draw.uniform();
  return twin;
}

/// @returns of the ways in one direction
/// @param record  gets the speed that was asked for and the readings of the whole sweep; may be none
ident::MeasuredMargins swept(const Twin& twin, const ident::AxisSettings& settings, std::uint64_t seed,
                             ident::Record* record = nullptr) {
  ident::TrialPlan plan = ident::trial_plan(settings);
  plan.sweep = ident::margin_sweep(settings, plan.step, 0.05);
  const ident::MarginSweep& sweep = *plan.sweep;
  const double h = settings.tick_s;
  hal::NormalNoise noise(seed);
  ident::AxisController controller(ident::coefficients(settings));
  double rod = 2.0;
  double speed = 0.0;
  double load = 0.0;
  controller.start(rod, settings.inverse.null);
  std::vector<double> readings;
  std::vector<double> asked;
  std::vector<double> injected;
  const double way = sweep.way();
  for (std::size_t row = 0; row < sweep.rows(); ++row) {
    const double share = static_cast<double>(row % sweep.way_rows()) / static_cast<double>(sweep.way_rows());
    const double set_point = 2.0 + way * (row / sweep.way_rows() % 2 == 0 ? share : 1.0 - share);
    const double reading = rod + twin.noise_in * noise();
    readings.push_back(reading);
    injected.push_back(sweep.injected(row));
    asked.push_back(settings.inverse.speed(controller.step(set_point, reading - injected.back()).command));
    const double wanted = twin.gain_share * asked.back();
    // Exact over a tick of a held command.
    const double decay = std::exp(-h / twin.lag_s);
    rod += wanted * h + (speed - wanted) * twin.lag_s * (1.0 - decay) + load * h;
    speed = wanted + (speed - wanted) * decay;
    load = 0.99 * load + twin.load_in_per_s * std::sqrt(1.0 - 0.99 * 0.99) * noise();
  }
  if (record != nullptr) {
    record->step_s = h;
    record->input = Eigen::Map<const Eigen::VectorXd>(asked.data(), static_cast<Eigen::Index>(asked.size()));
    record->output = Eigen::Map<const Eigen::VectorXd>(readings.data(), static_cast<Eigen::Index>(readings.size()));
  }
  std::vector<ident::SweepWay> ways;
  for (std::size_t i = 0; i < sweep.ways; i += 2) {
    const std::size_t begin = i * sweep.way_rows() + sweep.lead_rows;
    ways.push_back({std::span(injected).subspan(begin, sweep.measured_rows()),
                    std::span(readings).subspan(begin, sweep.measured_rows())});
  }
  return ident::measured_margins(sweep, settings, ways);
}

ident::AxisSettings known_settings() {
  ident::AxisSettings s;
  s.tick_s = 0.001;
  s.kind = ident::FeedbackKind::p;
  s.feedback = {.kp = 15.0, .filter_s = 0.003};
  s.most_speed = 1.0;
  s.inverse = {.null = -0.2, .dead_band = 0.15, .gain_positive = 0.148, .gain_negative = 0.13, .smoothing = 0.01};
  s.feed_forward.acceleration_s = 0.0075;
  s.reference = {.lowest = 0.15, .highest = 5.75, .velocity = 0.2, .acceleration = 1.0, .jerk = 40.0};
  s.command_min = -5.0;
  s.command_max = 5.0;
  s.slew_per_s = 20.0;
  return s;
}

/// Near the dead band noise bends the command: a sweep that comes there takes it for a greater gain.
TEST(MarginSweep, MeasuresTheRigsOwnGainBesideANoisySensor) {
  hal::SimOptions truth = std::get<hal::SimOptions>(config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml").backend);
  truth.sensor_noise_V = 0.003;
  truth.valve_dead_band_V = 0.3;
  truth.valve_rated_flow_L_per_min = 3.0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    truth.seed = seed;
    ident::PortableDraw draw(7000 + seed);
    const ident::AxisSettings settings = controller_for(truth, 0.001, draw);
    const ident::MeasuredMargins measured = swept(truth, settings);
    const double gain = measured.gain_share.value * settings.inverse.gain_positive;
    const double own = gains_of(truth).positive;
    EXPECT_NEAR(gain, own, measured.gain_share.half_width * settings.inverse.gain_positive) << seed;
    EXPECT_NEAR(gain, own, 0.03 * own) << seed;
  }
}

TEST(MarginSweep, IntervalsOfTheClosedLoopFitCover) {
  constexpr int kTwins = 300;
  const ident::AxisSettings settings = known_settings();
  int gain_covered = 0;
  int lag_covered = 0;
  double gain_error = 0.0;
  double lag_error = 0.0;
  double width = 0.0;
  for (int i = 0; i < kTwins; ++i) {
    const Twin twin = drawn_twin(i);
    const ident::MeasuredMargins m = swept(twin, settings, 50 + static_cast<std::uint64_t>(i));
    // A command acts one tick before the next reading: half a tick of the hold, and no more.
    const double lag_s = twin.lag_s + 0.5 * settings.tick_s;
    gain_covered += std::abs(m.gain_share.value - twin.gain_share) <= m.gain_share.half_width ? 1 : 0;
    lag_covered += std::abs(m.lag_s.value - lag_s) <= m.lag_s.half_width ? 1 : 0;
    gain_error += (m.gain_share.value / twin.gain_share - 1.0) / kTwins;
    lag_error += (m.lag_s.value - lag_s) / kTwins;
    width += m.gain_share.half_width / kTwins;
  }
  fmt::print("gain covered {} of {}, mean error {:+.3f} %, +- {:.2f} %; lag covered {}, mean error {:+.3f} ms\n",
             gain_covered, kTwins, 100.0 * gain_error, 100.0 * width, lag_covered, 1e3 * lag_error);
  EXPECT_GE(gain_covered, 0.93 * kTwins);
  EXPECT_LE(gain_covered, 0.97 * kTwins);
  EXPECT_GE(lag_covered, 0.93 * kTwins);
  EXPECT_LE(lag_covered, 0.97 * kTwins);
}

/// What docs/axis.md says of a fit of command and reading. EHA_SWEEP_TWINS: how many twins instead of 30.
TEST(MarginSweep, ADirectFitOfAClosedLoopIsBiased) {
  const int twins = drawn("EHA_SWEEP_TWINS", 30);
  const ident::AxisSettings settings = known_settings();
  ident::StructureOptions structure;
  structure.structure = ident::structures::integrator_lag();
  structure.name = "integrator_lag";
  ident::FitOptions options;
  options.decimation = 5;
  options.discard_s = 1.0;
  options.split = 1.0;
  options.intervals = ident::IntervalMethod::straight;
  double direct_error = 0.0;
  double swept_error = 0.0;
  std::vector<double> lag_errors_s;
  double swept_lag_s = 0.0;
  int covered = 0;
  for (int i = 0; i < twins; ++i) {
    Twin twin = drawn_twin(i);
    twin.load_in_per_s = 0.012;
    ident::Record record;
    const ident::MeasuredMargins m = swept(twin, settings, 50 + static_cast<std::uint64_t>(i), &record);
    const ident::Model model = ident::fit(record, structure, options).model;
    const auto value = [&](const char* name) -> const ident::ParameterEstimate& {
      return *std::find_if(model.parameters.begin(), model.parameters.end(),
                           [&](const ident::ParameterEstimate& p) { return p.name == name; });
    };
    direct_error += (value("K").value / twin.gain_share - 1.0) / twins;
    lag_errors_s.push_back(value("a2").value - twin.lag_s);
    covered += value("K").lower95 <= twin.gain_share && twin.gain_share <= value("K").upper95 ? 1 : 0;
    swept_error += (m.gain_share.value / twin.gain_share - 1.0) / twins;
    swept_lag_s += (m.lag_s.value - twin.lag_s - 0.5 * settings.tick_s) / twins;
  }
  std::sort(lag_errors_s.begin(), lag_errors_s.end());
  const double direct_lag_s = lag_errors_s[lag_errors_s.size() / 2];
  const auto mean = std::accumulate(lag_errors_s.begin(), lag_errors_s.end(), 0.0) / twins;
  fmt::print(
      "{} twins: direct fit: gain {:+.2f} %, its intervals cover {}, lag {:+.2f} ms (median; mean {:+.2f} ms); with "
      "the sweep as instrument: gain {:+.2f} %, lag {:+.2f} ms\n",
      twins, 100.0 * direct_error, covered, 1e3 * direct_lag_s, 1e3 * mean, 100.0 * swept_error, 1e3 * swept_lag_s);
  EXPECT_GT(mean, 3e-4);
  EXPECT_LT(std::abs(swept_lag_s), 0.5 * mean);
}

}  // namespace
}  // namespace eha::tune
