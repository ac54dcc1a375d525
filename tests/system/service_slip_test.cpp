// SPDX-License-Identifier: GPL-3.0-or-later
// Runs in which the sensor slipped or the rod did not follow, and what the service arms after them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <future>
#include <memory>
#include <ostream>
#include <string>
#include <thread>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "tests/system/arming_service.hpp"

namespace eha::test {
namespace {

TEST_F(ServiceArming, IsRefusedAfterASlipUntilARulerAgreesOrTheSensorIsCalibrated) {
  start();
  client_->call("arm");
  slip(0.07, "sensor_slip");
  for (int i = 0; i < 2; ++i) {  // not only once
    const Ended without = arm();
    EXPECT_EQ(without.code, kTrip) << without.err;
    EXPECT_NE(without.err.find("eha arm --ruler LENGTH"), std::string::npos) << without.err;
  }
  client_.reset();
  EXPECT_EQ(daemon_.stop(SIGTERM), 0);
  daemon_.start();
  EXPECT_EQ(arm().code, kTrip) << "the next service knows it, too";
  const double shown_in = rig_.card().position_in;
  const Ended elsewhere = arm({"--ruler", fmt::format("{:.3f}in", shown_in - 0.07)});
  EXPECT_EQ(elsewhere.code, static_cast<int>(ExitCode::configuration)) << shown_in << elsewhere.out << elsewhere.err;
  EXPECT_NE(elsewhere.err.find("eha calibrate --sensor-moved"), std::string::npos) << elsewhere.err;
  EXPECT_EQ(arm({"--ruler", fmt::format("{:.3f}in", shown_in)}).code, 0);
  client_ = std::make_unique<Client>(daemon_.socket());
  slip(0.3, "velocity_limit");
  EXPECT_EQ(arm().code, kTrip) << "another slip";
  client_->call("reload");
  EXPECT_EQ(arm().code, kTrip) << "by the same calibration";
  const std::string before = content_of(daemon_.rig_file());
  reload(text_with(before, kOffset, "offset_in = 2.93"));
  const Ended calibrated = arm();
  EXPECT_EQ(calibrated.code, 0) << calibrated.err;
  const Ended moved = run_eha({"goto", "3.2in", "--yes", "--socket", daemon_.socket()}, daemon_.folder());
  EXPECT_EQ(moved.code, 0) << "slips are counted anew: " << moved.err;
  client_->call("disarm");
  reload(before);
  EXPECT_EQ(arm().code, kTrip) << "of the first calibration nothing is known that was not known before";
}

TEST_F(ServiceArming, IsRefusedAfterTwoRunsInWhichTheRodDidNotMoveUntilARulerAgrees) {
  start();
  rig_.card().dead_band_V = 20.0;
  const auto move = [&] { return run_eha({"goto", "3.5in", "--yes", "--socket", daemon_.socket()}, daemon_.folder()); };
  for (int i = 0; i < 2; ++i) {
    const Ended armed = arm();
    EXPECT_EQ(armed.code, 0) << "after " << i << ": " << armed.err;
    EXPECT_EQ(move().code, kTrip);
  }
  const Ended without = arm();
  EXPECT_EQ(without.code, kTrip) << without.out;
  EXPECT_NE(without.err.find("eha arm --ruler LENGTH"), std::string::npos) << without.err;
  client_.reset();
  EXPECT_EQ(daemon_.stop(SIGTERM), 0);
  daemon_.start();
  EXPECT_EQ(arm().code, kTrip) << "the next service knows it, too";
  EXPECT_EQ(arm({"--ruler", fmt::format("{:.3f}in", rig_.card().position_in)}).code, 0);
  EXPECT_EQ(move().code, kTrip);
  EXPECT_EQ(arm().code, 0) << "counted anew";
}

TEST_F(ServiceArming, DrivesNoMachineByAnExperimentOfASimulatedRig) {
  start();
  const std::string machine = content_of(daemon_.rig_file());
  reload(content_of(source_file("config/rigs/sim.toml")));
  const std::int64_t entry = submit(*client_, quiet_experiment_text("simulated", 1.0), false);
  reload(machine);
  client_->call("arm");
  client_->call("release");
  const Json over = follow(daemon_, entry);
  EXPECT_EQ(over.at("outcome"), "refused") << over;
  EXPECT_NE(over.at("note").get<std::string>().find("submitted for a simulated rig"), std::string::npos) << over;
  EXPECT_EQ(rig_.card().enabled_ns, 0);
}

TEST_F(ServiceArming, ForgetsNoMissedMotionForAMoveThatMovesNothing) {
  start();
  const auto move = [&](const char* place) {
    return run_eha({"goto", place, "--yes", "--socket", daemon_.socket()}, daemon_.folder());
  };
  for (int i = 0; i < 2; ++i) {
    rig_.card().dead_band_V = 20.0;
    const Ended armed = arm();
    EXPECT_EQ(armed.code, 0) << "after " << i << ": " << armed.err;
    EXPECT_EQ(move("3.5in").code, kTrip);
    if (i == 1) break;
    EXPECT_EQ(arm().code, 0);
    const std::string here = fmt::format("{:.3f}in", rig_.card().position_in);
    EXPECT_EQ(move(here.c_str()).code, 0) << "it is in its place already";
  }
  EXPECT_EQ(arm().code, kTrip) << "the move between has shown no motion";
}

TEST_F(ServiceArming, IsRefusedOnceAfterASlipWhileNothingIsArmed) {
  start();
  EXPECT_EQ(arm().code, 0);
  client_->call("disarm");
  rig_.card().position_in -= 1.0;
  EXPECT_TRUE(daemon_.logs("the rod's reading moved by -1 in while nothing drove it")) << daemon_.log();
  const Ended refused = arm();
  EXPECT_NE(refused.code, 0);
  EXPECT_NE(refused.err.find("the rod's reading moved by -1"), std::string::npos) << refused.err;
  EXPECT_EQ(arm().code, 0) << "a person has looked";
}

TEST_F(ServiceArming, KnowsMissedMotionOfARunWhoseServiceWasKilledAsItTripped) {
  start();
  for (int i = 0; i < 2; ++i) {
    rig_.card().dead_band_V = 20.0;
    const Ended armed = arm();
    EXPECT_EQ(armed.code, 0) << "after " << i << ": " << armed.err;
    auto moving = std::async(std::launch::async, [&] {
      return run_eha({"goto", "3.5in", "--yes", "--socket", daemon_.socket()}, daemon_.folder());
    });
    const auto deadline = std::chrono::steady_clock::now() + kGenerous;
    while (!rig_.card().is_enabled() && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
    while (rig_.card().is_enabled() && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
    EXPECT_EQ(daemon_.stop(SIGKILL), 128 + SIGKILL);
    moving.wait();
    client_.reset();
    daemon_.start();
  }
  const Ended refused = arm();
  EXPECT_EQ(refused.code, kTrip) << refused.out << refused.err;
  EXPECT_NE(refused.err.find("did not do what the volts asked for"), std::string::npos) << refused.err;
}

TEST_F(ServiceArming, KnowsASlipOfARunWhoseServiceWasKilledAsItTripped) {
  start();
  client_->call("arm");
  const std::int64_t entry = submit(*client_, quiet_experiment_text("slips", 20.0), false);
  follow(daemon_, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  EXPECT_TRUE(rig_.is_driven(rig_.card().commands + 200)) << "rows for the monitor to know the noise";
  rig_.card().position_in += 0.07;
  const auto deadline = std::chrono::steady_clock::now() + kGenerous;
  while (rig_.card().is_enabled() && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  EXPECT_EQ(daemon_.stop(SIGKILL), 128 + SIGKILL);
  client_.reset();
  daemon_.start();
  const Ended without = arm();
  EXPECT_EQ(without.code, kTrip) << without.err << content_of(only_run(daemon_.runs()) / "run.json");
  EXPECT_NE(without.err.find("eha arm --ruler LENGTH"), std::string::npos) << without.err;
}

TEST_F(ServiceArming, AsksForARulerAfterARunWhoseRowsCannotBeRead) {
  start();
  client_->call("arm");
  const std::int64_t entry = submit(*client_, quiet_experiment_text("ends", 20.0), false);
  follow(daemon_, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  EXPECT_TRUE(rig_.is_driven(200)) << "before its run is named there is nothing to lose";
  EXPECT_EQ(daemon_.stop(SIGKILL), 128 + SIGKILL);
  client_.reset();
  std::ofstream(only_run(daemon_.runs()) / "raw.ehalog") << "not a journal";
  daemon_.start();
  const Ended without = arm();
  EXPECT_EQ(without.code, kTrip) << without.err;
  EXPECT_NE(without.err.find("eha arm --ruler LENGTH"), std::string::npos) << without.err;
}

TEST_F(ServiceArming, TakesTheCalibrationInForceForAnotherOneNotItsReading) {
  start();
  client_->call("arm");
  slip(0.07, "sensor_slip");
  const std::string old = content_of(daemon_.rig_file());
  reload(text_with(old, kOffset, "offset_in = 2.93"));
  reload(old);
  EXPECT_EQ(arm().code, kTrip) << "the calibration by which it slipped is in force again";
  reload(content_of(source_file("config/rigs/sim.toml")));
  EXPECT_EQ(arm().code, 0) << "no machine";
  client_->call("disarm");
  reload(old);
  EXPECT_EQ(arm().code, kTrip) << "a simulated rig says nothing of the machine's sensor";
}

TEST_F(ServiceArming, NamesTheRulerToWhoeverRanTheExperimentThatSlipped) {
  start();
  client_->call("arm");
  const auto file = daemon_.folder() / "slips.toml";
  std::ofstream(file) << quiet_experiment_text("slips", 20.0);
  auto run = std::async(std::launch::async, [&] {
    return run_eha({"run", file.string(), "--yes", "--socket", daemon_.socket()}, daemon_.folder());
  });
  EXPECT_TRUE(rig_.is_driven(200));
  rig_.card().position_in += 0.07;
  const Ended ended = run.get();
  EXPECT_EQ(ended.code, kTrip) << ended.err;
  EXPECT_NE(ended.err.find("the rig is disarmed; `eha arm --ruler LENGTH"), std::string::npos) << ended.err;
}

TEST_F(ServiceArming, TakesACalibrationThatARestartHasRead) {
  start();
  client_->call("arm");
  slip(0.07, "sensor_slip");
  client_.reset();
  EXPECT_EQ(daemon_.stop(SIGTERM), 0);
  const std::string calibrated = text_with(content_of(daemon_.rig_file()), kOffset, "offset_in = 2.93");
  std::ofstream(daemon_.rig_file()) << calibrated;
  daemon_.start();
  const Ended restarted = arm();
  EXPECT_EQ(restarted.code, 0) << restarted.err;
}

TEST_F(ServiceArming, OpensAClosedCardAfterASlipAndComparesTheRulerThen) {
  start();
  client_->call("arm");
  slip(0.07, "sensor_slip");
  const std::string sound = content_of(daemon_.rig_file());
  std::ofstream(daemon_.rig_file()) << text_with(sound, "board = \"pci1716\"", "board = \"pci1710\"");
  EXPECT_NE(refused(*client_, "reload").code, 0);
  std::ofstream(daemon_.rig_file()) << sound;
  const auto is_unknown = [this] { return client_->call("status").at("rod").at("error").is_string(); };
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!is_unknown() && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ASSERT_TRUE(is_unknown()) << "the card is closed";
  const Ended without = arm();
  EXPECT_EQ(without.code, kTrip) << without.err;
  const double shown_in = rig_.card().position_in;
  const Ended elsewhere = arm({"--ruler", fmt::format("{:.3f}in", shown_in - 0.07)});
  EXPECT_EQ(elsewhere.code, static_cast<int>(ExitCode::configuration)) << elsewhere.err;
  EXPECT_NE(client_->call("status").at("state"), "armed");
  const Ended same = arm({"--ruler", fmt::format("{:.3f}in", shown_in)});
  EXPECT_EQ(same.code, 0) << same.err;
}

/// eha-safe finds the card by the socket's folder. All users may open that folder, and so lock it.

}  // namespace
}  // namespace eha::test
