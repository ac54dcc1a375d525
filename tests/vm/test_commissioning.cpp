// SPDX-License-Identifier: GPL-3.0-or-later
// A technician's first hour with the rod behind the stand-in card's valve: sensor calibrated, valve measured, rod
// placed, in this process and through the service, by one user and by two.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "board.hpp"
#include "eha_run.hpp"
#include "service.hpp"

namespace eha::test {
namespace {

using Json = nlohmann::json;

constexpr ProcessOptions kAlice{.user = 1001};
constexpr ProcessOptions kBob{.user = 1002};
constexpr double kInPerVolt = 0.295;

/// Moves the rod by hand.
void place(const Board& board, double place_in) {
  board.set("rod_uV", static_cast<int>(std::lround((place_in - 2.95) / kInPerVolt * 1e6)));
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// The sheet of the card's valve: null 0 V, dead band 0.25 V, 0.14 in/(V s) both ways.
void expect_the_cards_valve(const Json& sheet) {
  const auto value = [&](const char* key) { return sheet.at(key).at("value").get<double>(); };
  std::cout << "commissioning: null " << value("null_V") << " V, dead band " << value("dead_band_V") << " V, gains "
            << value("gain_positive_in_per_V_s") << " and " << value("gain_negative_in_per_V_s") << " in/(V s)\n";
  EXPECT_NEAR(value("null_V"), 0.0, 0.009);
  EXPECT_NEAR(value("dead_band_V"), 0.25, 0.007);
  EXPECT_NEAR(value("gain_positive_in_per_V_s"), 0.14, 0.025 * 0.14);
  EXPECT_NEAR(value("gain_negative_in_per_V_s"), 0.14, 0.025 * 0.14);
}

/// A rig that ticks slower, of which the emulated machine plays more in a time.
std::string slow_rig() {
  return patient_pci1716_rig(
      {}, {{"sample_period_s", "0.005"}, {"abort_consecutive_late", "200"}, {"abort_total_late", "2000"}});
}

TEST(Commissioning, MeasuresTheValveThroughTheService) {
  const Board board("pci1716_card", kNoisyRod);
  const Service service(slow_rig());
  ASSERT_EQ(service.eha({"arm"}).wait(), 0);
  Process run = service.eha({"characterise", "--yes", "--json", "--quiet"});
  ASSERT_EQ(run.wait(), 0) << run.output();
  expect_the_cards_valve(Json::parse(run.output()));
  EXPECT_TRUE(wire_is_safe());
}

/// Of `eha read --json --quiet` [in].
double shown_place_in(Process& read) {
  if (read.wait() != 0) throw std::runtime_error(read.output());
  return Json::parse(read.output()).at("rod").at("displacement_in").get<double>();
}

/// Types positions while the rod is moved to them by hand.
/// @param shows  whether the sensor's reading of a place has reached the program
void calibrate(const Board& board, Process& process, const std::function<bool(double)>& shows) {
  std::size_t asked = 0;
  for (const char* position : {"0.75in", "2in", "3.25in", "127mm"}) {
    const double in = std::string(position) == "127mm" ? 5.0 : std::stod(position);
    // It asks for the next when it has read the last.
    const std::string prompt = "position " + std::to_string(++asked) + " [in]: ";
    ASSERT_TRUE(wait_until([&] { return has(process.output(), prompt); })) << process.output();
    place(board, in);
    ASSERT_TRUE(wait_until([&] { return shows(in); })) << position;
    process.type(position);
  }
  ASSERT_TRUE(wait_until([&] { return has(process.output(), "position 5 [in]: "); })) << process.output();
  process.type("");
  ASSERT_EQ(process.wait(), 0) << process.output();
  EXPECT_NEAR(true_place_in(board), 5.0, 1e-3) << "moved by something else than the hand";
}

/// By the new rig file the rod stands where the ruler says. The sensor gives 90 % of the volts of the old one.
void expect_calibrated(const Board& board, const std::string& rig) {
  for (const double in : {1.2, 4.4}) {
    place(board, in);
    Process read({"eha", "read", "--local", "--rig", rig, "--json", "--quiet"});
    EXPECT_NEAR(shown_place_in(read), in, 0.005);
  }
}

TEST(Commissioning, CalibratesTheSensor) {
  const Board board("pci1716_card", "rod=1 ai_noise=1 ai_slope_percent=90");
  const std::string rig = patient_pci1716_rig();
  const std::string calibrated = rig + ".local.toml";
  Process process({"eha", "calibrate", "--local", "--rig", rig, "-o", calibrated, "--sensor-moved"},
                  {.is_typed_into = true});
  calibrate(board, process, [](double) { return true; });
  expect_calibrated(board, calibrated);
  EXPECT_TRUE(wire_is_safe());
}

TEST(Commissioning, CalibratesTheSensorThroughTheService) {
  const Board board("pci1716_card", "rod=1 ai_noise=1 ai_slope_percent=90");
  const std::string rig = patient_pci1716_rig();
  const std::string calibrated = rig + ".service.toml";
  {
    const Service service(rig);
    Process process = service.eha({"calibrate", "-o", calibrated, "--sensor-moved"}, {.is_typed_into = true});
    // The service reads the sensor fifty times a second.
    calibrate(board, process, [&](double in) {
      Process read = service.eha({"read", "--json", "--quiet"});
      return std::abs(shown_place_in(read) - (2.95 + 0.9 * (in - 2.95))) < 0.005;
    });
  }
  expect_calibrated(board, calibrated);
  EXPECT_TRUE(wire_is_safe());
}

TEST(Commissioning, LetsOneUserDriveAndTheOtherLookAndStop) {
  const Board board("pci1716_card", kNoisyRod);
  const Service service(patient_pci1716_rig());
  const auto refused = [&](std::vector<std::string> words, const ProcessOptions& user) {
    Process process = service.eha(std::move(words), user);
    EXPECT_EQ(process.wait(), 77) << process.output();
    return process.output();
  };
  EXPECT_TRUE(has(refused({"goto", "3.5in", "--yes"}, kBob), "not armed by 1002: eha arm, then again"));
  ASSERT_EQ(service.eha({"arm"}, kAlice).wait(), 0);
  EXPECT_TRUE(has(refused({"goto", "3.5in", "--yes"}, kBob), "the lease is 1001's for another"));
  EXPECT_TRUE(has(refused({"jog", "+0.3in", "--yes"}, kBob), "the lease is 1001's for another"));
  EXPECT_TRUE(has(refused({"arm"}, kBob), "the lease is 1001's for another"));
  EXPECT_EQ(service.eha({"read"}, kBob).wait(), 0);
  EXPECT_NEAR(true_place_in(board), 2.95, 0.01);

  Process drives = service.eha({"goto", "3.9in", "--yes"}, kAlice);
  ASSERT_TRUE(wait_until([&] { return true_place_in(board) > 3.0; })) << drives.output();
  EXPECT_EQ(service.eha({"jog", "+0.1in", "--yes"}, kBob).wait(), 2) << "a run is on";
  Process stops = service.eha({"stop"}, kBob);
  EXPECT_EQ(stops.wait(), 0) << stops.output();
  EXPECT_EQ(drives.wait(), 130) << drives.output();
  EXPECT_TRUE(has(drives.output(), "interrupted by a stop request")) << drives.output();
  EXPECT_LT(true_place_in(board), 3.85);
  EXPECT_TRUE(wire_is_safe());

  // The lease is still Alice's, until she gives it back.
  EXPECT_TRUE(has(refused({"arm"}, kBob), "the lease is 1001's"));
  EXPECT_EQ(service.eha({"disarm"}, kAlice).wait(), 0);
  EXPECT_EQ(service.eha({"arm"}, kBob).wait(), 0);
  Process moves = service.eha({"jog", "-0.1in", "--yes"}, kBob);
  EXPECT_EQ(moves.wait(), 0) << moves.output();
  EXPECT_TRUE(wire_is_safe());
}

TEST(Commissioning, RefusesAPlaceBeyondTheLimit) {
  const Board board("pci1716_card", kNoisyRod);
  EhaRun run({"goto", "4in", "--rig", patient_pci1716_rig({}, {{"travel_max_in", "3.5"}})});
  EXPECT_EQ(run.process().wait(), 78) << run.process().output();
  EXPECT_TRUE(has(run.process().output(), "4 in is beyond the travel limits of the rig, 0.15 to 3.5 in"))
      << run.process().output();
  EXPECT_TRUE(run.left_nothing());
  EXPECT_NEAR(true_place_in(board), 2.95, 0.01);
  EXPECT_TRUE(wire_is_safe());
}

TEST(Commissioning, StopsSoonWhereTheSensorShowsHalfOfTheMotion) {
  // Not found, the rod would reach its end stop: the place lies beyond it.
  const Board board("pci1716_card", "rod=1 ai_noise=1 ai_slope_percent=50");
  EhaRun run({"goto", "4.9in", "--rig", patient_pci1716_rig()});
  EXPECT_EQ(run.process().wait(), 11) << run.process().output();
  EXPECT_TRUE(has(run.process().output(), "check the sensor")) << run.process().output();
  EXPECT_EQ(run.manifest().at("report").at("fault").at("cause"), "wrong_speed");
  EXPECT_NEAR(true_place_in(board), 2.95, 0.5);
  EXPECT_TRUE(wire_is_safe());
}

TEST(Commissioning, StopsWhereTheRodStandsBeyondALimit) {
  const Board board("pci1716_card", kNoisyRod);
  place(board, 4.2);
  EhaRun run({"goto", "3in", "--rig", patient_pci1716_rig({}, {{"travel_max_in", "4.0"}})});
  EXPECT_EQ(run.process().wait(), 2) << run.process().output();
  EXPECT_TRUE(has(run.process().output(), "--way-back")) << run.process().output();
  EXPECT_NEAR(true_place_in(board), 4.2, 1e-3);
  EXPECT_TRUE(wire_is_safe());
}

TEST(Commissioning, BringsARodInwardThatStandsBeyondALimit) {
  const Board board("pci1716_card", kNoisyRod);
  place(board, 4.2);
  EhaRun run({"goto", "3.5in", "--way-back", "--rig", patient_pci1716_rig({}, {{"travel_max_in", "4.0"}})});
  EXPECT_EQ(run.process().wait(), 0) << run.process().output();
  EXPECT_NEAR(true_place_in(board), 3.5, 0.04);
  EXPECT_TRUE(wire_is_safe());
}

}  // namespace
}  // namespace eha::test
