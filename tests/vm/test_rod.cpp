// SPDX-License-Identifier: GPL-3.0-or-later
// Faults of sensor, output and contactor on a rod behind the stand-in card's valve: the time until the hydraulics are
// off, on the wire, and where the rod truly was by then.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "board.hpp"
#include "eha_run.hpp"

namespace eha::test {
namespace {

using namespace std::chrono_literals;

constexpr double kNs = 1e-9;

/// A fault of the rig and what becomes of a run.
struct RodFault {
  std::string name;
  std::vector<std::pair<std::string, int>> before;  ///< parameters from the run's start
  std::vector<std::pair<std::string, int>> during;  ///< parameters when it is on
  std::string outcome;
  std::vector<std::string> causes;  ///< of the fault, any of them; none: it completes
  double safe_within_s = 0.0;       ///< from `during` to the enable line off [s]
  double travel_in = 0.0;           ///< most that the rod may truly move by then [in]
};

void PrintTo(const RodFault& fault, std::ostream* stream) { *stream << fault.name; }

class RodWith : public ::testing::TestWithParam<RodFault> {};

TEST_P(RodWith, EndsAsDocumentedAndInTime) {
  const RodFault& fault = GetParam();
  const Board board("pci1716_card", "rod=1 ai_noise=1");
  for (const auto& [parameter, value] : fault.before) board.set(parameter, value);
  EhaRun run(patient_pci1716_rig(), 8s, Tones::slow);
  run.wait_until_running();
  const double from_in = fault.before.empty() ? true_place_in(board) : 2.95;
  const std::int64_t from_ns = now_ns();
  for (const auto& [parameter, value] : fault.during) board.set(parameter, value);
  if (fault.causes.empty()) {
    run.wait_until_recorded();
  } else {
    run.process().wait();
  }
  const nlohmann::ordered_json manifest = run.manifest();
  ASSERT_EQ(manifest.at("outcome"), fault.outcome) << run.process().output();
  const double moved_in = std::abs(true_place_in(board) - from_in);
  const std::int64_t off_ns = off_since_ns();
  ASSERT_NE(off_ns, kNeverOff) << "the enable line is on";
  const double safe_s = static_cast<double>(off_ns - from_ns) * kNs;
  std::cout << "rod: " << fault.name << ": ";
  if (fault.causes.empty()) {
    std::cout << "not found; the run completed, the rod moved " << moved_in << " in\n";
    EXPECT_TRUE(manifest.at("report").at("fault").is_null());
    return;
  }
  const std::string cause = manifest.at("report").at("fault").at("cause");
  std::cout << cause << ", enable off after " << safe_s << " s, the rod moved " << moved_in << " in\n";
  EXPECT_NE(std::find(fault.causes.begin(), fault.causes.end(), cause), fault.causes.end()) << cause;
  EXPECT_LT(safe_s, fault.safe_within_s);
  EXPECT_LE(moved_in, fault.travel_in);
  // Nobody met an end stop.
  EXPECT_GT(true_place_in(board), 0.1);
  EXPECT_LT(true_place_in(board), 5.8);
}

INSTANTIATE_TEST_SUITE_P(
    OfTheStandInCard, RodWith,
    ::testing::Values(
        RodFault{"ASensorThatSticksWithNoise",
                 {},
                 {{"ai_noise", 5}, {"ai_stuck", 1}},
                 "faulted",
                 {"not_following"},
                 6.0,
                 0.7},
        RodFault{"ASensorThatIsStuckFromTheStart",
                 {{"ai_noise", 5}, {"ai_stuck", 1}},
                 {},
                 "faulted",
                 {"not_following"},
                 6.0,
                 0.7},
        RodFault{"AnOpenWireThatReadsMidStroke",
                 {{"ai_noise", 5}, {"ai_open", 1}},
                 {},
                 "faulted",
                 {"not_following"},
                 6.0,
                 0.7},
        RodFault{"AnOpenWireThatReadsTheRail",
                 {},
                 {{"ai_open_mV", 10000}, {"ai_open", 1}},
                 "faulted",
                 {"feedback_rail", "feedback_band"},
                 0.1,
                 0.05},
        RodFault{"AReversedSensor",
                 {{"ai_slope_percent", -100}},
                 {},
                 "faulted",
                 {"not_following", "unexplained_motion"},
                 6.0,
                 0.7},
        RodFault{"ASlopeThatHalved", {{"ai_slope_percent", 50}}, {}, "completed", {}, 0.0, 0.0},
        RodFault{
            "OutputTimeOuts", {}, {{"ao_timeout_ms", 1000}, {"ao_timeout", -1}}, "faulted", {"call_overran"}, 1.1, 0.5},
        RodFault{"AConverterThatStalls",
                 {},
                 {{"ai_stall_ms", 1000}, {"ai_stall", 1}},
                 "faulted",
                 {"loop_stalled"},
                 1.1,
                 0.5}),
    [](const auto& parameters) { return parameters.param.name; });

/// The shipped rig file with an auxiliary contact.
std::string rig_with_contact() {
  return patient_pci1716_rig(
      "\n[comedi.enable_contact]\nsubdevice = 2\nchannel = 1\nactive = \"high\"\nfollows_within_s = 0.05\n");
}

TEST(RodWithAContact, RunsWhileTheContactFollowsAndStopsWhenItDropsOut) {
  const Board board("pci1716_card", "rod=1 contact=1");
  EhaRun run(rig_with_contact(), 6s);
  run.wait_until_running();
  const std::int64_t from_ns = now_ns();
  board.set("contact", 2);
  EXPECT_EQ(run.process().wait(), 11) << run.process().output();
  EXPECT_EQ(run.manifest().at("report").at("fault").at("cause"), "enable_contact");
  const double safe_s = static_cast<double>(off_since_ns() - from_ns) * kNs;
  std::cout << "rod: a contactor that drops out: enable off after " << safe_s << " s\n";
  EXPECT_LT(safe_s, 0.15);
}

TEST(RodWithAContact, IsNotArmedWhileTheContactorIsWelded) {
  const Board board("pci1716_card", "rod=1 contact=3");
  EhaRun run(rig_with_contact(), 2s);
  EXPECT_EQ(run.process().wait(), 11);
  EXPECT_NE(run.process().output().find("welded"), std::string::npos) << run.process().output();
}

}  // namespace
}  // namespace eha::test
