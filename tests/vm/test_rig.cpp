// SPDX-License-Identifier: GPL-3.0-or-later
// hal/comedi on real ioctls: the kernel's own test board, and a stand-in for the PCI-1716 that fails on demand.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>

#include "board.hpp"
#include "core/error.hpp"
#include "hal/backends/backend.hpp"
#include "hal/comedi/comedi_rig.hpp"
#include "hal/snapshot_file.hpp"
#include "process.hpp"

namespace eha::test {
namespace {

using hal::AppliedCommand;
using hal::ComediOptions;
using hal::DigitalLine;
using hal::RigReading;
using hal::RigStatus;
using ::testing::Test;

constexpr double kSafe_V = 0.0;
constexpr std::int64_t kTick_ns = 1'000'000;

/// The wiring that the kernel's test board allows: outputs on subdevice 1 are read back on subdevice 0.
ComediOptions kernel_test_board() {
  ComediOptions options;
  options.board = "comedi_test";
  options.driver = "comedi_test";
  options.feedback.subdevice = 0;
  options.command.subdevice = 1;
  options.scale_in_per_V = 0.6;
  options.calibration_date = "2024-01-01";
  return options;
}

/// The same on the stand-in card, with all its digital lines.
ComediOptions stand_in_card() {
  ComediOptions options = kernel_test_board();
  options.board = "pci1716";
  options.driver = "adv_pci1710";
  options.emergency_stop = DigitalLine{2, 0, hal::ActiveLevel::high};
  options.enable = DigitalLine{3, 0, hal::ActiveLevel::high};
  options.heartbeat = DigitalLine{3, 1, hal::ActiveLevel::high};
  return options;
}

constexpr double kLsb_uV = 2.0 * kHalfLsb_uV;

std::string refusal_of(const ComediOptions& options) {
  try {
    const auto rig = hal::open_rig(options, kSafe_V);
    return rig->capabilities().board + " opened";
  } catch (const DeviceError& error) {
    return error.what();
  }
}

void expect_safe_wire() {
  const Wire wire = read_wire();
  EXPECT_NEAR(static_cast<double>(wire.ao0_uV), kSafe_V * 1e6, kLsb_uV);
  EXPECT_EQ(wire.digital_outputs & kEnableBit, 0);
}

TEST(ComediRigOnTheKernelTestBoard, ReadsBackEveryCommandAsTheSameCode) {
  const Board board("comedi_test");
  const auto rig = hal::open_rig(kernel_test_board(), kSafe_V);
  EXPECT_EQ(rig->capabilities().board, "comedi_test");
  EXPECT_TRUE(rig->capabilities().moves_machine);
  EXPECT_FALSE(rig->capabilities().has_virtual_clock);
  std::int64_t tick = 0;
  for (double command_V = -10.0; command_V <= 10.0; command_V += 0.01) {
    AppliedCommand applied;
    ASSERT_EQ(rig->command(command_V, applied), RigStatus::ok);
    EXPECT_NEAR(applied.applied_V, command_V, 0.5001 * rig->capabilities().command_lsb_V);
    RigReading reading;
    ASSERT_EQ(rig->read(++tick * kTick_ns, reading), RigStatus::ok);
    EXPECT_EQ(reading.feedback_code, applied.code);
    EXPECT_NEAR(reading.feedback_V, applied.applied_V, 1e-9);
    EXPECT_NEAR(reading.displacement_in, 0.6 * applied.applied_V, 1e-9);
  }
}

TEST(ComediRigOnTheKernelTestBoard, RefusesWhatTheCardIsNotAndSaysWhatItOffers) {
  const Board board("comedi_test");
  ComediOptions options = kernel_test_board();
  options.command.range_max_V = 7.0;
  EXPECT_NE(refusal_of(options).find("10"), std::string::npos) << refusal_of(options);
  options = kernel_test_board();
  options.board = "pci1716";
  EXPECT_NE(refusal_of(options).find("comedi_test"), std::string::npos) << refusal_of(options);
  options = kernel_test_board();
  options.resolution_bits = 12;
  EXPECT_NE(refusal_of(options).find("16"), std::string::npos) << refusal_of(options);
  options = kernel_test_board();
  options.device = "/dev/comedi7";
  EXPECT_NE(refusal_of(options).find("/dev/comedi7"), std::string::npos) << refusal_of(options);
}

TEST(ComediRigOnTheKernelTestBoard, RefusesADeviceThatAnotherHolds) {
  const Board board("comedi_test");
  const auto first = hal::open_rig(kernel_test_board(), kSafe_V);
  EXPECT_NE(refusal_of(kernel_test_board()).find("/dev/comedi0"), std::string::npos);
}

TEST(ComediRigOnTheKernelTestBoard, ReportsRemovalWhenTheBoardIsDetachedInUse) {
  const Board board("comedi_test");
  const auto rig = hal::open_rig(kernel_test_board(), kSafe_V);
  RigReading reading;
  ASSERT_EQ(rig->read(kTick_ns, reading), RigStatus::ok);
  ASSERT_EQ(Process({"comedi_config", "-r", "/dev/comedi0"}).wait(), 0);
  EXPECT_EQ(rig->read(2 * kTick_ns, reading), RigStatus::removed);
  AppliedCommand applied;
  EXPECT_EQ(rig->command(1.0, applied), RigStatus::removed);
  EXPECT_EQ(rig->make_safe(), RigStatus::removed);
}

/// A card and the rig on it.
class ComediRigOnTheStandInCard : public Test {
 protected:
  RigStatus read() { return rig->read(++tick * kTick_ns, reading); }

  Board board{"pci1716_card"};
  std::unique_ptr<hal::Rig> rig = hal::open_rig(stand_in_card(), kSafe_V);
  RigReading reading;
  AppliedCommand applied;
  std::int64_t tick = 0;
};

TEST_F(ComediRigOnTheStandInCard, IsSafeFromTheMomentItIsOpened) {
  expect_safe_wire();
  EXPECT_TRUE(rig->capabilities().has_emergency_stop);
  EXPECT_TRUE(rig->capabilities().has_enable);
  EXPECT_TRUE(rig->capabilities().has_heartbeat);
  EXPECT_EQ(rig->capabilities().driver, "adv_pci1710");
}

TEST_F(ComediRigOnTheStandInCard, EnablesOnlyAfterTheOutputLeftTheLowerEndOfItsRange) {
  ASSERT_EQ(rig->set_enable(true), RigStatus::ok);
  bool enabled = false;
  for (const WireChange& change : read_wire_changes()) {
    if (change.wire == "do") enabled = (change.value & kEnableBit) != 0;
    if (enabled && change.wire == "ao0") {
      EXPECT_GT(change.value, -9'000'000);
    }
  }
  EXPECT_TRUE(enabled);
}

TEST_F(ComediRigOnTheStandInCard, MeasuresThroughAnotherRangeThanItCommands) {
  rig.reset();
  ComediOptions options = stand_in_card();
  options.feedback.range_min_V = 0.0;
  options.command.range_min_V = -5.0;
  options.command.range_max_V = 5.0;
  rig = hal::open_rig(options, kSafe_V);
  for (const double command_V : {0.5, 2.0, 4.5}) {
    ASSERT_EQ(rig->command(command_V, applied), RigStatus::ok);
    ASSERT_EQ(read(), RigStatus::ok);
    EXPECT_NEAR(reading.feedback_V, command_V, 10.0 / 0xffff);
    EXPECT_FALSE(reading.feedback_at_rail);
  }
  ASSERT_EQ(rig->command(-1.0, applied), RigStatus::ok);
  ASSERT_EQ(read(), RigStatus::ok);
  EXPECT_EQ(reading.feedback_code, 0U);
  EXPECT_TRUE(reading.feedback_at_rail);
}

TEST_F(ComediRigOnTheStandInCard, TogglesTheHeartbeatWithEachCommandAndLeavesTheEnableAlone) {
  ASSERT_EQ(rig->set_enable(true), RigStatus::ok);
  std::int64_t last = read_wire().digital_outputs & kHeartbeatBit;
  for (int i = 0; i < 10; ++i) {
    ASSERT_EQ(rig->command(0.1 * i, applied), RigStatus::ok);
    const std::int64_t outputs = read_wire().digital_outputs;
    EXPECT_NE(outputs & kHeartbeatBit, last);
    EXPECT_NE(outputs & kEnableBit, 0);
    last = outputs & kHeartbeatBit;
  }
}

TEST_F(ComediRigOnTheStandInCard, SeesTheEmergencyStopOpen) {
  ASSERT_EQ(read(), RigStatus::ok);
  EXPECT_FALSE(reading.emergency_stop);
  board.set("di", 0xfffe);
  ASSERT_EQ(read(), RigStatus::ok);
  EXPECT_TRUE(reading.emergency_stop);
}

TEST_F(ComediRigOnTheStandInCard, TellsAConverterTimeOutFromAnIoError) {
  board.set("ai_timeout", 1);
  EXPECT_EQ(read(), RigStatus::timed_out);
  EXPECT_EQ(read(), RigStatus::ok);
  board.set("ai_io_error", 1);
  EXPECT_EQ(read(), RigStatus::io_error);
  EXPECT_EQ(read(), RigStatus::ok);
}

TEST_F(ComediRigOnTheStandInCard, ReportsADeadCardAsFeedbackAtTheRail) {
  board.set("all_ones", 1);
  ASSERT_EQ(read(), RigStatus::ok);
  EXPECT_EQ(reading.feedback_code, 0xffffU);
  EXPECT_TRUE(reading.feedback_at_rail);
}

TEST_F(ComediRigOnTheStandInCard, RefusesToWriteWhatIsNoVoltage) {
  ASSERT_EQ(rig->command(1.0, applied), RigStatus::ok);
  const std::int64_t before = read_wire().ao0_uV;
  EXPECT_EQ(rig->command(std::numeric_limits<double>::quiet_NaN(), applied), RigStatus::not_finite);
  EXPECT_EQ(read_wire().ao0_uV, before);
}

TEST_F(ComediRigOnTheStandInCard, SwitchesTheEnableOffThenWritesTheSafeVoltage) {
  ASSERT_EQ(rig->set_enable(true), RigStatus::ok);
  ASSERT_EQ(rig->command(3.0, applied), RigStatus::ok);
  const std::size_t before = read_wire_changes().size();
  ASSERT_EQ(rig->make_safe(), RigStatus::ok);
  expect_safe_wire();
  const std::vector<WireChange> changes = read_wire_changes();
  ASSERT_GE(changes.size(), before + 2);
  EXPECT_EQ(changes[before].wire, "do");
  EXPECT_EQ(changes[before + 1].wire, "ao0");
}

TEST_F(ComediRigOnTheStandInCard, ReportsRemoval) {
  board.set("removed", 1);
  EXPECT_EQ(read(), RigStatus::removed);
  EXPECT_EQ(rig->command(1.0, applied), RigStatus::removed);
}

TEST_F(ComediRigOnTheStandInCard, IsNotMadeSafeFromItsSnapshotWhileItsOwnerHoldsIt) {
  ASSERT_EQ(rig->set_enable(true), RigStatus::ok);
  ASSERT_EQ(rig->command(3.0, applied), RigStatus::ok);
  EXPECT_THROW(hal::safe_action(rig->safe_snapshot(), "snapshot").make_safe(std::chrono::milliseconds(50)),
               DeviceError);
  EXPECT_NEAR(static_cast<double>(read_wire().ao0_uV), 3e6, kLsb_uV);
}

TEST_F(ComediRigOnTheStandInCard, IsMadeSafeFromItsSnapshotAfterItsOwnerWasKilled) {
  rig.reset();
  const std::string snapshot = "/tmp/snapshot.json";
  const pid_t owner = fork();
  if (owner == 0) {
    const auto owned = hal::open_rig(stand_in_card(), kSafe_V);
    hal::write_safe_snapshot(owned->safe_snapshot(), snapshot);
    owned->set_enable(true);
    owned->command(3.0, applied);
    std::raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(owner, &status, 0), owner);
  ASSERT_TRUE(WIFSIGNALED(status));
  ASSERT_NEAR(static_cast<double>(read_wire().ao0_uV), 3e6, kLsb_uV);  // the output outlives its process
  ASSERT_NE(read_wire().digital_outputs & kEnableBit, 0);
  hal::safe_action(hal::read_safe_snapshot(snapshot), "snapshot").make_safe(std::chrono::seconds(1));
  expect_safe_wire();
}

}  // namespace
}  // namespace eha::test
