// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/sim/sim_rig.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/error.hpp"

namespace eha::hal {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;

/// Feedback codes of a rig driven by a square wave, which needs no mathematical library.
std::vector<std::uint32_t> square_wave_codes(const SimOptions& options, int ticks) {
  const auto rig = open_rig(options, 0.0);
  std::vector<std::uint32_t> codes;
  EXPECT_EQ(rig->set_enable(true), RigStatus::ok);
  for (int k = 0; k < ticks; ++k) {
    RigReading reading;
    AppliedCommand applied;
    EXPECT_EQ(rig->read(k * kTick_ns, reading), RigStatus::ok);
    EXPECT_EQ(rig->command((k / 500) % 2 == 0 ? 2.5 : -2.5, applied), RigStatus::ok);
    codes.push_back(reading.feedback_code);
  }
  return codes;
}

TEST(SimRig, GivesTheSameCodesForTheSameSeedOnly) {
  SimOptions options;
  const auto first = square_wave_codes(options, 3000);
  EXPECT_EQ(square_wave_codes(options, 3000), first);
  options.seed = 2;
  EXPECT_NE(square_wave_codes(options, 3000), first);
}

TEST(SimRig, GivesTheCodesThatItGaveOnEveryOtherMachine) {
  // FNV-1a over the codes. A change of the model or of its shipped parameters may change it; a compiler or a
  // processor must not.
  std::uint64_t hash = 14695981039346656037U;
  for (const std::uint32_t code : square_wave_codes(SimOptions(), 3000)) hash = (hash ^ code) * 1099511628211U;
  EXPECT_EQ(hash, 7782966201205329257U);
}

TEST(SimRig, ReportsDisplacementByItsCalibration) {
  SimOptions options;
  options.scale_in_per_V = -0.5;
  options.offset_in = 4.0;
  options.sensor_noise_V = 0.0;
  const auto rig = open_rig(options, 0.0);
  RigReading reading;
  ASSERT_EQ(rig->read(0, reading), RigStatus::ok);
  const RigCapabilities& can = rig->capabilities();
  EXPECT_NEAR(reading.displacement_in, options.initial_displacement_in, 0.5 * can.feedback_lsb_V * 0.5);
  EXPECT_DOUBLE_EQ(reading.displacement_in, 4.0 - 0.5 * reading.feedback_V);
  EXPECT_DOUBLE_EQ(reading.feedback_V, can.feedback_min_V + can.feedback_lsb_V * reading.feedback_code);
  EXPECT_FALSE(reading.feedback_at_rail);
  EXPECT_FALSE(reading.emergency_stop);
}

TEST(SimRig, FlagsASensorThatLeavesTheConverterRange) {
  SimOptions options;
  options.feedback_max_V = 2.0;
  const auto rig = open_rig(options, 0.0);
  RigReading reading;
  ASSERT_EQ(rig->read(0, reading), RigStatus::ok);
  EXPECT_TRUE(reading.feedback_at_rail);
  EXPECT_EQ(reading.feedback_code, 65535U);
}

TEST(SimRig, AddsTheNoiseThatItsOptionsSay) {
  SimOptions options;
  options.sensor_noise_V = 0.01;
  const auto rig = open_rig(options, 0.0);
  const int count = 20000;
  double sum = 0.0;
  double squares = 0.0;
  for (int k = 0; k < count; ++k) {
    RigReading reading;
    rig->read(0, reading);
    sum += reading.feedback_V;
    squares += reading.feedback_V * reading.feedback_V;
  }
  const double mean = sum / count;
  EXPECT_NEAR(std::sqrt(squares / count - mean * mean), 0.01, 0.0005);
  EXPECT_NEAR(mean, options.initial_displacement_in / options.scale_in_per_V, 5.0 * 0.01 / std::sqrt(count));
}

TEST(SimRig, AppliesTheNearestCodeAndSaysWhichVoltageThatIs) {
  const auto rig = open_rig(SimOptions(), 0.0);
  AppliedCommand applied;
  ASSERT_EQ(rig->command(1.23456, applied), RigStatus::ok);
  EXPECT_NEAR(applied.applied_V, 1.23456, 0.5 * rig->capabilities().command_lsb_V);
  EXPECT_DOUBLE_EQ(applied.applied_V, -10.0 + rig->capabilities().command_lsb_V * applied.code);
  ASSERT_EQ(rig->command(400.0, applied), RigStatus::ok);
  EXPECT_DOUBLE_EQ(applied.applied_V, 10.0);
}

TEST(SimRig, RefusesACommandThatIsNotANumberAndHoldsTheLastOne) {
  const auto rig = open_rig(SimOptions(), 0.0);
  AppliedCommand applied;
  ASSERT_EQ(rig->command(1.0, applied), RigStatus::ok);
  const AppliedCommand before = applied;
  EXPECT_EQ(rig->command(std::numeric_limits<double>::quiet_NaN(), applied), RigStatus::not_finite);
  EXPECT_EQ(rig->command(std::numeric_limits<double>::infinity(), applied), RigStatus::not_finite);
  EXPECT_EQ(applied.code, before.code);
}

TEST(SimRig, HoldsTheRodWhileDisabledAndDriftsAtZeroVoltsWhileEnabled) {
  SimOptions options;
  options.sensor_noise_V = 0.0;
  const auto rig = open_rig(options, 0.0);
  RigReading start;
  RigReading held;
  RigReading drifted;
  RigReading safe;
  RigReading later;
  AppliedCommand applied;
  rig->read(0, start);
  ASSERT_EQ(rig->command(5.0, applied), RigStatus::ok);
  rig->read(10'000 * kTick_ns, held);
  EXPECT_EQ(held.feedback_code, start.feedback_code) << "opened with the hydraulics off";
  rig->command(0.0, applied);
  ASSERT_EQ(rig->set_enable(true), RigStatus::ok);
  rig->read(20'000 * kTick_ns, drifted);
  EXPECT_GT(drifted.displacement_in, held.displacement_in + 0.01);
  rig->command(5.0, applied);
  ASSERT_EQ(rig->make_safe(), RigStatus::ok);
  rig->read(20'100 * kTick_ns, safe);
  rig->read(30'000 * kTick_ns, later);
  EXPECT_NEAR(later.displacement_in, safe.displacement_in, 0.012) << "0.3 mm, the oil's give";
}

TEST(SimRig, GoesOnFromWhereItStandsWhenANewRunBegins) {
  SimOptions options;
  options.sensor_noise_V = 0.0;
  const auto rig = open_rig(options, 0.0);
  RigReading end;
  RigReading next;
  AppliedCommand applied;
  rig->set_enable(true);
  rig->command(3.0, applied);
  rig->read(1000 * kTick_ns, end);
  rig->read(0, next);
  EXPECT_EQ(next.feedback_code, end.feedback_code);
  rig->read(500 * kTick_ns, next);
  EXPECT_GT(next.displacement_in, end.displacement_in);
}

TEST(SimRig, RefusesParametersThatMakeNoSense) {
  SimOptions options;
  options.rod_mm = 50.0;
  try {
    (void)open_rig(options, 20.0);
    FAIL() << "opened";
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(),
                 "sim.rod_mm: expected less than bore_mm = 40, got 50\n"
                 "sim.command_min_V: expected to hold the rig's safe voltage, from -10 to 10 V, got 20");
  }
}

}  // namespace
}  // namespace eha::hal
