// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/replay/replay_rig.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "core/error.hpp"
#include "hal/sim/sim_rig.hpp"

namespace eha::hal {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;

std::vector<RigReading> three_readings() {
  std::vector<RigReading> readings(3);
  for (std::size_t i = 0; i < readings.size(); ++i) {
    readings[i].displacement_in = 1.0 + static_cast<double>(i);
    readings[i].feedback_code = 100 + static_cast<std::uint32_t>(i);
    readings[i].emergency_stop = i == 2;
  }
  return readings;
}

RigCapabilities sixteen_bits() {
  RigCapabilities can;
  can.backend = "comedi";
  can.board = "pci1716";
  can.command_min_V = -10.0;
  can.command_max_V = 10.0;
  can.command_lsb_V = 20.0 / 65535.0;
  return can;
}

TEST(ReplayRig, PlaysTheRowOfTheTimeAndTheLastRowFromThenOn) {
  ReplayRig rig(three_readings(), kTick_ns, sixteen_bits(), 0.0);
  const std::pair<std::int64_t, std::uint32_t> expected[] = {
      {0, 100}, {kTick_ns - 1, 100}, {kTick_ns, 101}, {2 * kTick_ns, 102}, {50 * kTick_ns, 102}, {0, 100}};
  for (const auto& [elapsed_ns, code] : expected) {
    RigReading reading;
    ASSERT_EQ(rig.read(elapsed_ns, reading), RigStatus::ok);
    EXPECT_EQ(reading.feedback_code, code) << elapsed_ns;
    EXPECT_DOUBLE_EQ(reading.displacement_in, code - 99.0);
    EXPECT_EQ(reading.emergency_stop, code == 102);
  }
}

TEST(ReplayRig, KeepsWhatWouldHaveBeenAppliedBesideEachRow) {
  ReplayRig rig(three_readings(), kTick_ns, sixteen_bits(), 0.5);
  RigReading reading;
  AppliedCommand applied;
  rig.read(0, reading);
  ASSERT_EQ(rig.command(1.0, applied), RigStatus::ok);
  EXPECT_NEAR(applied.applied_V, 1.0, 10.0 / 65535.0);
  rig.set_enable(true);
  rig.read(kTick_ns, reading);
  rig.command(2.0, applied);
  rig.command(20.0, applied);
  EXPECT_EQ(rig.commands()[1].code, 65535U) << "the last command counts, clamped to the range";
  EXPECT_TRUE(rig.enabled());
  rig.read(2 * kTick_ns, reading);
  EXPECT_EQ(rig.command(std::numeric_limits<double>::quiet_NaN(), applied), RigStatus::not_finite);
  EXPECT_EQ(rig.commands()[2].code, 0U);
  EXPECT_EQ(rig.make_safe(), RigStatus::ok);
  EXPECT_NEAR(rig.commands()[2].applied_V, 0.5, 10.0 / 65535.0);
  EXPECT_FALSE(rig.enabled());
  EXPECT_EQ(rig.capabilities().backend, "replay");
  EXPECT_EQ(rig.capabilities().board, "pci1716");
  EXPECT_TRUE(rig.capabilities().virtual_time);
}

TEST(ReplayRig, AppliesTheVeryCodesOfTheRigThatWasRecorded) {
  const auto sim = open_sim(SimOptions(), 0.0);
  ReplayRig rig(three_readings(), kTick_ns, sim->capabilities(), 0.0);
  for (int i = 0; i <= 4000; ++i) {
    const double command_V = -10.0 + i * 0.005;
    AppliedCommand recorded;
    AppliedCommand replayed;
    sim->command(command_V, recorded);
    rig.command(command_V, replayed);
    ASSERT_EQ(replayed.code, recorded.code) << command_V;
    ASSERT_NEAR(replayed.applied_V, recorded.applied_V, 1e-12);
  }
}

TEST(ReplayRig, RefusesARecordThatCannotBePlayed) {
  EXPECT_THROW(ReplayRig({}, kTick_ns, sixteen_bits(), 0.0), DataError);
  EXPECT_THROW(ReplayRig(three_readings(), 0, sixteen_bits(), 0.0), DataError);
  EXPECT_THROW(ReplayRig(three_readings(), kTick_ns, RigCapabilities(), 0.0), DataError);
}

}  // namespace
}  // namespace eha::hal
