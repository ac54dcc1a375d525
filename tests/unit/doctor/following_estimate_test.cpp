// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/following_estimate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "core/error.hpp"
#include "hal/sim/sim_rig.hpp"

namespace eha::doctor {
namespace {

constexpr double kStep_s = 0.001;

struct Record {
  std::vector<double> input;
  std::vector<double> output;
};

/// Volts of a sum of three slow sines; its peak is `peak_V`.
std::vector<double> slow_sines(double peak_V, double offset_V, double duration_s) {
  std::vector<double> volts(static_cast<std::size_t>(std::llround(duration_s / kStep_s)));
  for (std::size_t k = 0; k < volts.size(); ++k) {
    const double t = static_cast<double>(k) * kStep_s;
    double sum = 0.0;
    for (const double frequency_Hz : {0.1, 0.23, 0.41}) sum += std::sin(2.0 * std::numbers::pi * frequency_Hz * t);
    volts[k] = offset_V + peak_V * sum / 3.0;
  }
  return volts;
}

/// The simulated rig's answer, row k sampled before u[k].
Record play(const hal::SimOptions& plant, const std::vector<double>& volts) {
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(plant, 0.0);
  EXPECT_EQ(rig->set_enable(true), hal::RigStatus::ok);
  Record record;
  for (std::size_t k = 0; k < volts.size(); ++k) {
    hal::RigReading reading;
    hal::AppliedCommand applied;
    EXPECT_EQ(rig->read(static_cast<std::int64_t>(k) * 1'000'000, reading), hal::RigStatus::ok);
    EXPECT_EQ(rig->command(volts[k], applied), hal::RigStatus::ok);
    record.input.push_back(applied.applied_V);
    record.output.push_back(reading.displacement_in);
  }
  return record;
}

FollowingEstimate estimate(const Record& record) { return estimate_following(record.input, record.output, kStep_s); }

std::string refusal(const Record& record) {
  try {
    static_cast<void>(estimate(record));
  } catch (const DataError& error) {
    return error.what();
  }
  return "";
}

/// Mean speed at a held command, once it is steady [in/s].
double steady_speed(const hal::SimOptions& plant, double command_V) {
  const Record record = play(plant, std::vector<double>(600, command_V));
  return (record.output[599] - record.output[299]) / 0.3;
}

TEST(FollowingEstimate, RecoversTheSimulatedRigsValve) {
  const hal::SimOptions plant;
  const FollowingEstimate found = estimate(play(plant, slow_sines(2.0, -0.2, 60.0)));
  EXPECT_NEAR(found.following.null_V, -0.2, 0.03);
  EXPECT_NEAR(found.dead_band_V, 0.15, 0.05);
  EXPECT_NEAR(found.following.dead_band_V, found.dead_band_V + 0.05, 1e-12);
  // Those of the shipped rig file, which come from steps.
  EXPECT_NEAR(found.following.gain_positive_in_per_V_s, 0.074, 0.1 * 0.074);
  EXPECT_NEAR(found.following.gain_negative_in_per_V_s, 0.065, 0.1 * 0.065);
  EXPECT_EQ(found.following.limit_in, 0.1);
  EXPECT_LT(found.null_error_V, 0.03);
  EXPECT_LT(found.peak_missing, 0.5);
  EXPECT_LT(found.peak_excess, 0.5);
}

TEST(FollowingEstimate, RecoversValvesOfOtherRigs) {
  std::mt19937_64 random(11);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int i = 0; i < 12; ++i) {
    hal::SimOptions plant;
    plant.valve_dead_band_V = uniform(0.05, 0.6);
    plant.valve_null_offset_V = uniform(-0.3, 0.3);
    const double friction = std::exp(uniform(0.0, std::log(3.0)));
    plant.coulomb_friction_N *= friction;
    plant.static_friction_N *= friction;
    plant.viscous_friction_N_s_per_mm *= friction;
    plant.friction_regularisation_mm_per_s *= friction;
    plant.moving_mass_kg *= uniform(1.0, 3.0);
    plant.sensor_noise_V = uniform(0.0003, 0.005);
    plant.seed = random();
    const double null_V = -plant.valve_null_offset_V;
    const FollowingEstimate found = estimate(play(plant, slow_sines(plant.valve_dead_band_V + 2.0, null_V, 60.0)));
    SCOPED_TRACE("rig " + std::to_string(i));
    EXPECT_NEAR(found.following.null_V, null_V, 0.03);
    EXPECT_NEAR(found.dead_band_V, plant.valve_dead_band_V, 0.05);
    constexpr double kOutside_V = 1.0;
    const double step_V = plant.valve_dead_band_V + kOutside_V;
    EXPECT_NEAR(found.gain_in_per_V_s[0] / (steady_speed(plant, null_V + step_V) / kOutside_V), 1.0, 0.12);
    EXPECT_NEAR(found.gain_in_per_V_s[1] / (-steady_speed(plant, null_V - step_V) / kOutside_V), 1.0, 0.12);
  }
}

TEST(FollowingEstimate, RefusesRunsThatHoldTooLittle) {
  const hal::SimOptions plant;
  EXPECT_NE(refusal({{0.0}, {2.95}}).find("rows"), std::string::npos);
  EXPECT_NE(refusal(play(plant, slow_sines(0.1, -0.2, 60.0))).find("the rod moved"), std::string::npos)
      << "within the dead band";
  EXPECT_NE(refusal(play(plant, std::vector<double>(8000, 1.0))).find("the rod moved"), std::string::npos) << "one way";
  EXPECT_NE(refusal(play(plant, slow_sines(2.0, -0.2, 0.9))).find("rows"), std::string::npos) << "0.9 s";
}

TEST(FollowingEstimate, RefusesASensorThatDoesNotFollow) {
  const hal::SimOptions plant;
  Record record = play(plant, slow_sines(2.0, -0.2, 60.0));
  Record reversed = record;
  for (double& place_in : reversed.output) place_in = 5.9 - place_in;
  EXPECT_NE(refusal(reversed), "");
  Record noise = record;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(2.95, 0.05);
  for (double& place_in : noise.output) place_in = normal(random);
  EXPECT_NE(refusal(noise), "");
  // It follows for half of the run, and then stands still.
  Record stuck = record;
  for (std::size_t k = stuck.output.size() / 2; k < stuck.output.size(); ++k) {
    stuck.output[k] = stuck.output[stuck.output.size() / 2];
  }
  EXPECT_NE(refusal(stuck), "");
}

TEST(FollowingEstimate, GivesLinesForARigFile) {
  FollowingEstimate estimate;
  estimate.following = {.gain_positive_in_per_V_s = 0.0742,
                        .gain_negative_in_per_V_s = 0.0655,
                        .null_V = -0.2,
                        .dead_band_V = 0.21,
                        .limit_in = 0.1,
                        .pressure_delay_s = 0.0};
  const std::string lines = to_rig_lines(estimate);
  EXPECT_TRUE(lines.starts_with("[following]\n")) << lines;
  for (const char* line : {"\ngain_positive_in_per_V_s = 0.0742 ", "\ngain_negative_in_per_V_s = 0.0655 ",
                           "\nnull_V = -0.200 ", "\ndead_band_V = 0.210 ", "\nlimit_in = 0.1 "}) {
    EXPECT_NE(lines.find(line), std::string::npos) << lines;
  }
}

}  // namespace
}  // namespace eha::doctor
