// SPDX-License-Identifier: GPL-3.0-or-later
// A controller made for the rod behind the stand-in card's valve, played on it: its promise, through the service too,
// and what becomes of the trial on a stop, a killed process and a failing sensor.
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "board.hpp"
#include "eha_run.hpp"
#include "service.hpp"

namespace eha::test {
namespace {

using Json = nlohmann::json;

constexpr const char* kTick_s = "0.005";

std::string rig() {
  return patient_pci1716_rig(
      {}, {{"sample_period_s", kTick_s}, {"abort_consecutive_late", "200"}, {"abort_total_late", "2000"}});
}

/// Made by `run`, outside the machine: emulated, tuning takes minutes.
constexpr const char* kController = "/usr/share/axis.toml";

std::vector<std::string> trial(const std::string& rig_file) {
  std::vector<std::string> words{"track", kController, "--step", "0.2in", "--sine", "0.05in", "--hold", "2"};
  if (!rig_file.empty()) words.insert(words.end(), {"--rig", rig_file});
  return words;
}

TEST(TrackOnTheCard, KeepsItsPromiseThroughTheService) {
  const Board board("pci1716_card", kNoisyRod);
  const Service service(rig());
  ASSERT_EQ(service.eha({"arm"}).wait(), 0);
  std::vector<std::string> words = trial({});
  words.emplace_back("--yes");
  Process run = service.eha(words);
  // A promise that is not kept is exit code 3.
  ASSERT_EQ(run.wait(), 0) << run.output();
  EXPECT_TRUE(wire_is_safe());
}

/// What happens in the trial, and how far the rod may truly move by then [in].
struct Event {
  std::string name;
  std::vector<std::pair<std::string, int>> during;  ///< parameters of the card
  int signal = 0;
  double safe_within_s = 0.0;
};
void PrintTo(const Event& event, std::ostream* stream) { *stream << event.name; }

class TrackWith : public ::testing::TestWithParam<Event> {};

TEST_P(TrackWith, EndsSafeNearWhereItWas) {
  const Event& event = GetParam();
  const Board board("pci1716_card", kNoisyRod);
  EhaRun run(trial(rig()));
  run.wait_until_running();
  // Into the step.
  const timespec rest{.tv_sec = 2, .tv_nsec = 0};
  nanosleep(&rest, nullptr);
  const double from_in = true_place_in(board);
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  for (const auto& [parameter, value] : event.during) board.set(parameter, value);
  if (event.signal != 0) run.process().signal(event.signal);
  EXPECT_NE(run.process().wait(), 0) << run.process().output();
  timespec poll{.tv_sec = 0, .tv_nsec = 50'000'000};
  for (int i = 0; i < 200 && off_since_ns() == kNeverOff; ++i) nanosleep(&poll, nullptr);
  const std::int64_t off_ns = off_since_ns();
  ASSERT_NE(off_ns, kNeverOff) << "the enable line is on";
  const double safe_s = 1e-9 * static_cast<double>(off_ns - now.tv_nsec) - static_cast<double>(now.tv_sec);
  const double moved_in = std::abs(true_place_in(board) - from_in);
  std::cout << "track: " << event.name << ": off after " << safe_s << " s, the rod moved " << moved_in << " in\n";
  EXPECT_LT(safe_s, event.safe_within_s);
  EXPECT_LE(moved_in, 0.5);
  EXPECT_TRUE(wire_is_safe());
}

INSTANTIATE_TEST_SUITE_P(OfTheStandInCard, TrackWith,
                         ::testing::Values(Event{"Interrupted", {}, SIGINT, 2.0}, Event{"Killed", {}, SIGKILL, 1.0},
                                           Event{"ASensorThatSticks", {{"ai_noise", 5}, {"ai_stuck", 1}}, 0, 4.0},
                                           Event{"AReversedSensor", {{"ai_slope_percent", -100}}, 0, 2.0},
                                           Event{"AHalvedSlope", {{"ai_slope_percent", 50}}, 0, 4.0},
                                           Event{"AnOpenWire", {{"ai_open_mV", 10000}, {"ai_open", 1}}, 0, 0.2}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace eha::test
