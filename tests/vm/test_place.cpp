// SPDX-License-Identifier: GPL-3.0-or-later
// A rod behind the stand-in card's valve is read, placed and held, with the faults of that.
#include <gtest/gtest.h>

#include <csignal>
#include <iostream>
#include <string>

#include "board.hpp"
#include "eha_run.hpp"

namespace eha::test {
namespace {

using namespace std::chrono_literals;

bool hydraulics_are_on() { return (read_wire().digital_outputs & 1) != 0; }

std::string cause_of(const EhaRun& run) { return run.manifest().at("report").at("fault").at("cause"); }

TEST(Placing, ReadsAndMovesTheRodToItsPlace) {
  const Board board("pci1716_card", kNoisyRod);
  const std::string rig = patient_pci1716_rig();
  Process read({"eha", "read", "--local", "--rig", rig});
  EXPECT_EQ(read.wait(), 0) << read.output();
  EXPECT_NE(read.output().find("2.9"), std::string::npos) << read.output();
  EhaRun go_to({"goto", "3.2in", "--rig", rig});
  EXPECT_EQ(go_to.process().wait(), 0) << go_to.process().output();
  EXPECT_NEAR(true_place_in(board), 3.2, 0.04);
  EXPECT_FALSE(hydraulics_are_on());
  EhaRun jog({"jog", "-0.1in", "--rig", rig});
  EXPECT_EQ(jog.process().wait(), 0) << jog.process().output();
  EXPECT_NEAR(true_place_in(board), 3.1, 0.06);
}

TEST(Placing, StopsWhenTheSensorIsLost) {
  const Board board("pci1716_card", kNoisyRod);
  EhaRun jog({"jog", "+1in", "--rig", patient_pci1716_rig()});
  jog.wait_until_running();
  board.set("ai_noise", 5);
  board.set("ai_stuck", 1);
  EXPECT_EQ(jog.process().wait(), 11) << jog.process().output();
  EXPECT_EQ(cause_of(jog), "no_motion");
  EXPECT_FALSE(hydraulics_are_on());
  std::cout << "placing: the rod ended at " << true_place_in(board) << " in\n";
  EXPECT_LT(true_place_in(board), 4.65) << "0.7 in beyond where it was to go";
}

TEST(Placing, StopsAtALimit) {
  const Board board("pci1716_card", kNoisyRod);
  EhaRun go_to({"goto", "3.95in", "--rig", patient_pci1716_rig()});
  go_to.wait_until_running();
  // The wire now reads 5.8 in.
  board.set("ai_open_mV", 9660);
  board.set("ai_open", 1);
  EXPECT_EQ(go_to.process().wait(), 11) << go_to.process().output();
  const std::string cause = cause_of(go_to);
  EXPECT_TRUE(cause == "travel_limit" || cause == "velocity_limit" || cause == "feedback_band") << cause;
  EXPECT_FALSE(hydraulics_are_on());
}

TEST(Placing, RampsOutOnCtrlCAndKeepsAnotherUserFromTheRig) {
  const Board board("pci1716_card", kNoisyRod);
  const std::string rig = patient_pci1716_rig();
  EhaRun go_to({"goto", "4in", "--rig", rig});
  go_to.wait_until_running();
  EhaRun other({"goto", "2in", "--rig", rig});
  EXPECT_EQ(other.process().wait(), 69) << other.process().output();
  go_to.process().signal(SIGINT);
  EXPECT_EQ(go_to.process().wait(), 130) << go_to.process().output();
  EXPECT_EQ(go_to.manifest().at("outcome"), "interrupted");
  EXPECT_FALSE(hydraulics_are_on());
}

TEST(Hold, RampsOutOnCtrlC) {
  const Board board("pci1716_card", kNoisyRod);
  EhaRun run(patient_pci1716_rig(), 20s, Tones::held);
  run.wait_until_running();
  run.process().signal(SIGINT);
  EXPECT_EQ(run.process().wait(), 130) << run.process().output();
  EXPECT_EQ(run.manifest().at("outcome"), "interrupted");
  EXPECT_TRUE(run.manifest().at("experiment").at("hold").is_object());
  EXPECT_FALSE(hydraulics_are_on());
}

}  // namespace
}  // namespace eha::test
