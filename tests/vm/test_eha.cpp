// SPDX-License-Identifier: GPL-3.0-or-later
// The real eha on real ioctls: runs, refusals, and the end when the card or eha itself fails.
#include <comedilib.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "board.hpp"
#include "daemon/record/recover.hpp"
#include "eha_run.hpp"

namespace eha::test {
namespace {

using acquisition::State;
using acquisition::TickRecord;
using namespace std::chrono_literals;

constexpr const char* kQuietRod = "rod=1";

std::vector<pid_t> children_of(pid_t parent) {
  std::vector<pid_t> children;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/" + std::to_string(parent) + "/task")) {
    std::ifstream file(thread.path() / "children");
    for (pid_t child = 0; file >> child;) children.push_back(child);
  }
  return children;
}

std::vector<TickRecord> experiment_rows(const std::vector<TickRecord>& ticks) {
  std::vector<TickRecord> rows;
  std::copy_if(ticks.begin(), ticks.end(), std::back_inserter(rows),
               [](const TickRecord& tick) { return tick.state == State::running; });
  return rows;
}

TEST(EhaOnTheKernelTestBoard, PlaysAMultisineAndReadsBackEveryCommand) {
  const Board board("comedi_test");
  EhaRun run(kernel_board_rig(), 2000ms, Tones::faint);
  const int exit_code = run.process().wait();
  // Whether a model of a wire passes validation is no matter here.
  EXPECT_TRUE(exit_code == 0 || exit_code == 3) << exit_code << ": " << run.process().output();
  EXPECT_EQ(run.manifest().at("outcome"), "completed");
  const std::vector<TickRecord> ticks = run.ticks();
  EXPECT_EQ(experiment_rows(ticks).size(), 2000U);
  for (std::size_t k = 1; k < ticks.size(); ++k) {
    ASSERT_EQ(ticks[k].sequence, ticks[k - 1].sequence + 1);
    ASSERT_EQ(ticks[k].flags & acquisition::kSkipped, 0);
    ASSERT_EQ(ticks[k].feedback_code, ticks[k - 1].command_code) << "row " << k;
  }
}

/// eha's message about a wrong rig file; checks that no file is left behind.
void expect_refusal(const std::string& rig_file, const std::string& reason) {
  EhaRun run(rig_file, 2000ms, Tones::faint);
  EXPECT_EQ(run.process().wait(), 69);
  EXPECT_NE(run.process().output().find(reason), std::string::npos) << run.process().output();
  EXPECT_TRUE(run.left_nothing());
}

TEST(EhaOnTheKernelTestBoard, RefusesARangeThatTheCardDoesNotHaveAndSaysWhichItHas) {
  const Board board("comedi_test");
  expect_refusal(kernel_board_rig(RigFile::wrong_range), "-10..10");
}

TEST(EhaOnTheKernelTestBoard, RefusesAnotherBoard) {
  const Board board("comedi_test");
  expect_refusal(kernel_board_rig(RigFile::wrong_board), "comedi_test");
}

TEST(EhaOnTheKernelTestBoard, RefusesAMissingDevice) {
  const Board board("comedi_test");
  expect_refusal(kernel_board_rig(RigFile::missing_device), "/dev/comedi7");
}

TEST(EhaOnTheKernelTestBoard, RefusesADeviceThatAnotherProcessHasLocked) {
  const Board board("comedi_test");
  comedi_t* device = comedi_open("/dev/comedi0");
  ASSERT_NE(device, nullptr);
  ASSERT_EQ(comedi_lock(device, 1), 0);
  expect_refusal(kernel_board_rig(), "/dev/comedi0");
  comedi_close(device);
}

TEST(EhaOnTheKernelTestBoard, FailsTheRunWhenItsBoardIsDetached) {
  const Board board("comedi_test");
  EhaRun run(kernel_board_rig(), 20s, Tones::faint);
  run.wait_until_running();
  ASSERT_EQ(Process({"comedi_config", "-r", "/dev/comedi0"}).wait(), 0);
  EXPECT_EQ(run.process().wait(), 69);
  EXPECT_NE(run.process().output().find("device_removed"), std::string::npos) << run.process().output();
  EXPECT_NE(run.process().output().find("NOT CONFIRMED SAFE"), std::string::npos) << run.process().output();
  EXPECT_EQ(run.manifest().at("outcome"), "faulted");
  EXPECT_GT(run.ticks().size(), 200U);
}

TEST(EhaOnTheStandInCard, RunsTheShippedRigFileAsItIs) {
  const Board board("pci1716_card", kQuietRod);
  EhaRun run(pci1716_rig(), 1500ms);
  run.wait_until_recorded();
  EXPECT_EQ(run.manifest().at("outcome"), "completed");
  const std::vector<TickRecord> ticks = run.ticks();
  EXPECT_EQ(experiment_rows(ticks).size(), 1500U);
  // The card's rod: 0.14 in/(V s) of what exceeds 0.25 V, in the time between two readings, which jitters.
  double expected_in = ticks.front().displacement_in;
  double farthest_in = 0.0;
  for (std::size_t k = 1; k < ticks.size(); ++k) {
    const double volts = ticks[k - 1].applied_V;
    if (ticks[k - 1].state != State::armed) {
      expected_in += 0.00014 * std::copysign(std::max(0.0, std::abs(volts) - 0.25), volts);
    }
    ASSERT_NEAR(ticks[k].displacement_in, expected_in, 0.01) << "row " << k;
    farthest_in = std::max(farthest_in, std::abs(expected_in - 2.95));
  }
  EXPECT_GT(farthest_in, 0.05) << "it moved";
  EXPECT_TRUE(wire_is_safe());
}

TEST(EhaOnTheStandInCard, EnablesTheHydraulicsForTheRunOnlyAndBeatsItsHeartWithEveryTick) {
  const Board board("pci1716_card", kQuietRod);
  EhaRun run(patient_pci1716_rig(), 500ms);
  run.wait_until_recorded();
  bool enabled = false;
  bool was_enabled = false;
  std::int64_t beats = 0;
  std::int64_t last = 0;
  for (const WireChange& change : read_wire_changes()) {
    if (change.wire == "do") {
      enabled = (change.value & kEnableBit) != 0;
      was_enabled = was_enabled || enabled;
      if (((change.value ^ last) & kHeartbeatBit) != 0) ++beats;
      last = change.value;
    } else if (!enabled) {
      // Off the run, nothing but the safe voltage, the card's own reset, and the range's lower end before it is set.
      EXPECT_TRUE(std::abs(static_cast<double>(change.value)) <= kHalfLsb_uV ||
                  (!was_enabled && change.value == -5'000'000))
          << change.value;
    }
  }
  EXPECT_TRUE(was_enabled);
  EXPECT_NEAR(static_cast<double>(beats), static_cast<double>(run.ticks().size()), 3.0);
  EXPECT_TRUE(wire_is_safe());
}

/// A fault of the card during a run and the expected end.
struct CardFault {
  std::string name;
  std::vector<std::pair<std::string, int>> parameters;
  std::string outcome;
  std::string cause;
  int exit_code;
};

void PrintTo(const CardFault& fault, std::ostream* stream) { *stream << fault.name; }

class EhaOnTheStandInCardWith : public ::testing::TestWithParam<CardFault> {};

TEST_P(EhaOnTheStandInCardWith, EndsFaultedAndSafeOnTheWire) {
  const CardFault& fault = GetParam();
  const Board board("pci1716_card", kQuietRod);
  EhaRun run(fault.outcome == "deadline" ? pci1716_rig() : patient_pci1716_rig(), 20s);
  run.wait_until_running();
  EXPECT_FALSE(wire_is_safe());
  for (const auto& [parameter, value] : fault.parameters) board.set(parameter, value);
  EXPECT_EQ(run.process().wait(), fault.exit_code) << run.process().output();
  EXPECT_TRUE(wire_is_safe());
  const nlohmann::ordered_json manifest = run.manifest();
  EXPECT_EQ(manifest.at("outcome"), fault.outcome);
  EXPECT_EQ(manifest.at("report").at("final_state"), "faulted");
  EXPECT_EQ(manifest.at("report").at("fault").at("cause"), fault.cause);
  EXPECT_NE(run.process().output().find(fault.cause), std::string::npos) << run.process().output();
}

INSTANTIATE_TEST_SUITE_P(
    Mid, EhaOnTheStandInCardWith,
    ::testing::Values(
        CardFault{"TimeOuts", {{"ai_timeout", -1}}, "faulted", "repeated_timeouts", 69},
        CardFault{"ATimeOutThatTakesTooLong", {{"ai_timeout_ms", 3}, {"ai_timeout", 1}}, "faulted", "call_overran", 69},
        CardFault{"IoErrors", {{"ai_io_error", -1}}, "faulted", "read_failed", 69},
        CardFault{"AStuckSensor", {{"ai_stuck", 1}}, "faulted", "frozen_sensor", 11},
        CardFault{"AllOnes", {{"all_ones", 1}}, "faulted", "feedback_rail", 11},
        CardFault{"TheEmergencyStopOpen", {{"di", 0xfffe}}, "faulted", "emergency_stop", 11},
        CardFault{"AStallOfManyTicks", {{"ai_stall_ms", 20}, {"ai_stall", 1}}, "deadline", "consecutive_late", 12},
        CardFault{"Removal", {{"removed", 1}}, "faulted", "device_removed", 69}),
    [](const auto& parameters) { return parameters.param.name; });

TEST(EhaOnTheStandInCard, ToleratesOneTimeOutAndFlagsTheHeldSample) {
  const Board board("pci1716_card", kQuietRod);
  EhaRun run(patient_pci1716_rig(), 1500ms);
  run.wait_until_running();
  board.set("ai_timeout", 1);
  run.wait_until_recorded();
  EXPECT_EQ(run.manifest().at("outcome"), "completed") << run.process().output();
  const std::vector<TickRecord> ticks = run.ticks();
  EXPECT_EQ(std::count_if(ticks.begin(), ticks.end(),
                          [](const TickRecord& tick) { return (tick.flags & acquisition::kFeedbackHeld) != 0; }),
            1);
}

TEST(EhaOnTheStandInCard, CountsTheTicksThatAStalledConversionCosts) {
  const Board board("pci1716_card", kQuietRod);
  EhaRun run(patient_pci1716_rig(), 1500ms);
  run.wait_until_running();
  board.set("ai_stall_ms", 3);
  board.set("ai_stall", 1);
  run.wait_until_recorded();
  EXPECT_EQ(run.manifest().at("outcome"), "completed") << run.process().output();
  EXPECT_GE(run.manifest().at("report").at("counters").at("skipped").get<int>(), 2);
  EXPECT_EQ(experiment_rows(run.ticks()).size(), 1500U);
}

TEST(EhaOnTheStandInCard, RampsOutOnSigterm) {
  const Board board("pci1716_card", kQuietRod);
  EhaRun run(patient_pci1716_rig(), 20s);
  run.wait_until_running();
  const std::int64_t signalled_ns = now_ns();
  run.process().signal(SIGTERM);
  EXPECT_EQ(run.process().wait(), 130) << run.process().output();
  EXPECT_EQ(run.manifest().at("outcome"), "interrupted");
  EXPECT_TRUE(wire_is_safe());
  std::vector<std::int64_t> outputs_uV;
  for (const WireChange& change : read_wire_changes()) {
    if (change.wire == "ao0" && change.time_ns > signalled_ns) outputs_uV.push_back(change.value);
  }
  // The slew limit of pci1716.toml, 20 V/s, holds to the end: 20 mV a tick, and a step of the converter.
  ASSERT_GT(outputs_uV.size(), 2U);
  for (std::size_t i = 1; i < outputs_uV.size(); ++i) {
    EXPECT_LE(std::abs(outputs_uV[i] - outputs_uV[i - 1]), 20'000 + 153);
  }
}

TEST(EhaOnTheStandInCard, IsMadeSafeWithinHalfASecondOfSigkillAndKeepsItsRecord) {
  const Board board("pci1716_card", kQuietRod);
  EhaRun run(patient_pci1716_rig(), 20s);
  run.wait_until_running();
  ASSERT_FALSE(wire_is_safe());
  const std::int64_t killed_ns = now_ns();
  run.process().signal(SIGKILL);
  ASSERT_EQ(run.process().wait(), 128 + SIGKILL);
  ASSERT_TRUE(wait_until(wire_is_safe));
  const std::vector<WireChange> changes = read_wire_changes();
  EXPECT_LT(changes.back().time_ns - killed_ns, 500'000'000);

  const record::Recovery recovery = record::recover_run(run.folder());
  EXPECT_TRUE(recovery.changed);
  // Every tick beats the heart once. The log holds all of them: the run was killed within two seconds.
  std::int64_t beats = 0;
  std::int64_t last = 0;
  for (const WireChange& change : changes) {
    if (change.wire != "do") continue;
    if (change.time_ns <= killed_ns && ((change.value ^ last) & kHeartbeatBit) != 0) ++beats;
    last = change.value;
  }
  EXPECT_GE(static_cast<std::int64_t>(recovery.rows), beats - 200);
  EXPECT_LE(static_cast<std::int64_t>(recovery.rows), beats + 2);
  EXPECT_EQ(run.manifest().at("outcome"), "recovered");
}

TEST(EhaOnTheStandInCard, IsKilledByItsGuardAndMadeSafeWhenItIsStopped) {
  const Board board("pci1716_card", kQuietRod);
  EhaRun run(patient_pci1716_rig(), 20s);
  run.wait_until_running();
  ASSERT_FALSE(wire_is_safe());
  const std::int64_t stopped_ns = now_ns();
  run.process().signal(SIGSTOP);
  EXPECT_EQ(run.process().wait(), 128 + SIGKILL);
  ASSERT_TRUE(wait_until(wire_is_safe));
  EXPECT_LT(read_wire_changes().back().time_ns - stopped_ns, 1'000'000'000);
}

class GuardLost : public ::testing::TestWithParam<int> {};

TEST_P(GuardLost, RampsOutAndSaysSo) {
  const Board board("pci1716_card", kQuietRod);
  EhaRun run(patient_pci1716_rig(), 20s);
  run.wait_until_running();
  const std::vector<pid_t> children = children_of(run.process().id());
  ASSERT_EQ(children.size(), 1U);
  ASSERT_EQ(kill(children.front(), GetParam()), 0);
  EXPECT_EQ(run.process().wait(), 69);
  EXPECT_TRUE(wire_is_safe());
  EXPECT_NE(run.process().output().find("the guard of the rig"), std::string::npos) << run.process().output();
  EXPECT_EQ(run.manifest().at("outcome"), "interrupted");
}

INSTANTIATE_TEST_SUITE_P(EhaOnTheStandInCard, GuardLost, ::testing::Values(SIGKILL, SIGSTOP));

}  // namespace
}  // namespace eha::test
