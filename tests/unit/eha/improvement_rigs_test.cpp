// SPDX-License-Identifier: GPL-3.0-or-later
// An experiment designed from a model, tried out on a twin that is calibrated by the same record, and played on ten
// simulated rigs: what was predicted against what came of it. Minutes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "config/prepared_experiment.hpp"
#include "config/rig_config.hpp"
#include "daemon/eha/design_choice.hpp"
#include "daemon/identify/executor.hpp"
#include "daemon/replay/calibration.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/excitation/excitation.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::cli {
namespace {

using ident::Model;
using ident::synthetic::uniform;

constexpr double kFactor = 1.5;
constexpr int kPaperRecords = 4;
const std::string kSource = EHA_SOURCE_DIR;

/// The shipped rig with other oil, mass, friction, valve and noise.
hal::SimOptions perturbed_rig(int number) {
  std::mt19937_64 draw(static_cast<std::uint64_t>(number));
  const auto between = [&](double low, double high) { return low + (high - low) * uniform(draw); };
  hal::SimOptions rig;
  rig.bulk_modulus_bar = between(5500.0, 9000.0);
  rig.moving_mass_kg = between(15.0, 30.0);
  rig.coulomb_friction_N = between(80.0, 160.0);
  rig.viscous_friction_N_s_per_mm = between(4.0, 8.0);
  rig.valve_dead_band_V = between(0.1, 0.2);
  rig.valve_null_offset_V = between(0.15, 0.25);
  rig.valve_natural_frequency_Hz = between(35.0, 50.0);
  return rig;
}

Model fitted(const hal::SimOptions& rig, const Eigen::VectorXd& volts, const ident::ImprovementTask& task,
             std::uint64_t seed) {
  ident::StructureOptions asked;
  asked.name = "fo_valve";
  asked.structure = ident::structures::behind_valve(ident::structures::fo());
  ident::FitOptions options = task.options;
  options.intervals = ident::IntervalMethod::straight;
  return ident::fit(replay::recorded(rig, volts, task.limits.step_s, seed), asked, options).model;
}

double std_of(const Model& model) {
  for (const ident::ParameterEstimate& p : model.parameters) {
    if (p.name == "n2") return p.std;
  }
  return NAN;
}

class ImprovementOnRig : public testing::TestWithParam<int> {};

TEST_P(ImprovementOnRig, AchievesWhatItPredicts) {
  const config::RigConfig shipped = config::load_rig(kSource + "/config/rigs/sim.toml");
  const config::PreparedExperiment paper =
      config::load_prepared_experiment(kSource + "/config/experiments/paper.toml", shipped);
  ident::ImprovementTask task;
  task.duration_s = paper.config.duration_s;
  task.options = paper.config.fit;
  task.limits = {.lowest_V = shipped.limits.command_min_V,
                 .highest_V = shipped.limits.command_max_V,
                 .slew_V_per_s = shipped.limits.slew_V_per_s,
                 .lowest_output = shipped.limits.travel_min_in,
                 .highest_output = shipped.limits.travel_max_in,
                 .step_s = shipped.realtime.sample_period_s};
  const hal::SimOptions rig = perturbed_rig(GetParam());
  const auto seed = 100 * static_cast<std::uint64_t>(GetParam());
  const Model before = fitted(rig, paper.table_V, task, seed);

  // Nobody knows the rig; its twin is the shipped one, calibrated by the record.
  const ident::Record record = replay::recorded(rig, paper.table_V, task.limits.step_s, seed);
  const replay::Calibration calibration =
      replay::calibrate(std::get<hal::SimOptions>(shipped.backend),
                        {{"valve_null_offset_V", {}}, {"valve_dead_band_V", {}}, {"coulomb_friction_N", {}}},
                        record.input, record.output, task.limits.step_s, identify::thread_executor());
  const DesignPredictor predictor{before, "n2", calibration.options, identify::thread_executor()};
  const double promised_by_paper = predicted_by(predictor, paper, task);
  const ChosenDesign chosen = choose_design(predictor, task);
  const ident::Improvement& found = chosen.design;

  const auto samples = static_cast<std::size_t>(std::llround(task.duration_s / task.limits.step_s));
  const Eigen::VectorXd volts = ident::excitation({.kind = ident::Multisine{found.tones}, .offset_V = found.offset_V},
                                                  task.limits.step_s, samples);
  const double achieved = std_of(fitted(rig, volts, task, seed + 1));
  double by_paper = std::log(std_of(before));
  for (std::uint64_t i = 1; i < kPaperRecords; ++i) {
    by_paper += std::log(std_of(fitted(rig, paper.table_V, task, seed + 10 + i)));
  }
  by_paper = std::exp(by_paper / kPaperRecords);
  std::printf(
      "rig %d: n2 +- %.4f by the paper's tones (predicted %.4f), %.4f by the design (predicted %.4f, %.4f to %.4f)\n",
      GetParam(), by_paper, promised_by_paper, achieved, found.std, chosen.trial->lowest, chosen.trial->highest);
  EXPECT_LE(achieved, kFactor * found.std);
  EXPECT_GE(achieved, found.std / kFactor);
  // Smaller than by the paper's tones, by the factor promised.
  const double gain = by_paper / achieved;
  EXPECT_GT(gain, 1.0);
  EXPECT_LE(std::abs(std::log(gain / (promised_by_paper / found.std))), 2.0 * std::log(kFactor));
}

INSTANTIATE_TEST_SUITE_P(Ten, ImprovementOnRig, testing::Range(1, 11));

}  // namespace
}  // namespace eha::cli
