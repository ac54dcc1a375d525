// SPDX-License-Identifier: GPL-3.0-or-later
// What the service does not arm: the built programs on the stand-in card.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/file.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <future>
#include <memory>
#include <ostream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "tests/system/arming_service.hpp"

namespace eha::test {
namespace {

TEST_F(ServiceArming, IsRefusedWhileTheEmergencyStopCircuitIsOpen) {
  start();
  rig_.card().digital_inputs = 0;
  const Refused open = refused(*client_, "arm");
  EXPECT_EQ(open.code, static_cast<int>(ExitCode::safety_trip));
  EXPECT_NE(open.message.find("emergency-stop circuit is open"), std::string::npos) << open.message;
  EXPECT_EQ(client_->call("status").at("state"), "faulted");
  rig_.card().digital_inputs = 1;
  EXPECT_EQ(client_->call("arm").at("state"), "armed");
  EXPECT_EQ(rig_.card().enabled_ns, 0) << "arming powers nothing";
}

TEST_F(ServiceArming, DrivesNothingWithAStoppedGuardAndStartsAnother) {
  start();
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(client_->call("arm").at("state"), "armed");
    const pid_t guard = child_of(daemon_.pid());
    ASSERT_EQ(kill(guard, SIGSTOP), 0);
    const Ended moved = run_eha({"goto", "3.2in", "--yes", "--socket", daemon_.socket()}, daemon_.folder());
    EXPECT_NE(moved.code, 0) << moved.out;
    EXPECT_EQ(rig_.card().enabled_ns, 0) << moved.err;
    EXPECT_NE(client_->call("status").at("state"), "armed");
    EXPECT_EQ(client_->call("arm").at("state"), "armed") << "with another guard";
    EXPECT_NE(child_of(daemon_.pid()), guard);
    EXPECT_EQ(client_->call("disarm").at("state"), "idle");
  }
}

TEST_F(ServiceArming, LeavesTheFolderOfItsSocketToOneServiceWhoeverLocksIt) {
  const os::FileDescriptor of_anybody = os::open_file(daemon_.folder(), O_RDONLY | O_DIRECTORY);
  ASSERT_EQ(flock(of_anybody.get(), LOCK_EX | LOCK_NB), 0);
  start();
  std::string second = "env";
  for (const std::string& variable : rig_.environment()) second += " " + variable;
  second += fmt::format(" {} --rig {} --state {} --socket {} 2>&1; echo \"ended: $?\"", EHAD_PROGRAM,
                        daemon_.rig_file().string(), (daemon_.folder() / "state_2").string(),
                        (daemon_.folder() / "second.sock").string());
  const std::string said = output_of_shell(second);
  EXPECT_NE(said.find("another ehad that drives a card"), std::string::npos) << said;
  EXPECT_NE(said.find("ended: 69"), std::string::npos) << said;
  EXPECT_EQ(client_->call("arm").at("state"), "armed");
}

/// The rig file of the stand-in card, nothing known of its valve.
std::string uncharacterised_rig() {
  std::string text = DrivenRig::rig_text(std::nullopt);
  const std::size_t following = text.find("\n[following]");
  return text.erase(following, text.find("\n[", following + 1) - following);
}

TEST_F(ServiceArming, PlaysNothingButACharacterisationWithoutFollowing) {
  std::ofstream(daemon_.rig_file()) << uncharacterised_rig();
  for (const std::string& variable : rig_.environment()) daemon_.set_environment(variable);
  daemon_.start();
  const Ended armed = run_eha({"arm", "--socket", daemon_.socket()}, daemon_.folder());
  EXPECT_EQ(armed.code, 0) << armed.err;
  EXPECT_NE(armed.err.find("nothing but `eha characterise"), std::string::npos) << armed.err;
  EXPECT_NE(armed.out.find("Next: eha characterise"), std::string::npos) << armed.out;
  const std::string paper = source_file("config/experiments/paper.toml");
  const std::vector<std::vector<std::string>> moves{{"goto", "3.2in", "--yes"},
                                                    {"jog", "+0.1in", "--yes"},
                                                    {"run", paper, "--yes"},
                                                    {"run", paper, "--yes", "--detach"},
                                                    {"check", paper}};
  for (std::vector<std::string> words : moves) {
    words.insert(words.end(), {"--socket", daemon_.socket()});
    const Ended refused = run_eha(words, daemon_.folder());
    EXPECT_EQ(refused.code, static_cast<int>(ExitCode::configuration)) << words.front() << refused.out;
    EXPECT_NE(refused.err.find("nothing but `eha characterise"), std::string::npos) << refused.err;
  }
  EXPECT_TRUE(Client(daemon_.socket()).call("queue").at("entries").empty());
  EXPECT_EQ(rig_.card().enabled_ns, 0);
}

TEST_F(ServiceArming, AsksForARulersReadingBeforeTheFirstMotionWithoutFollowing) {
  std::ofstream(daemon_.rig_file()) << uncharacterised_rig();
  for (const std::string& variable : rig_.environment()) daemon_.set_environment(variable);
  daemon_.start();
  Client(daemon_.socket()).call("arm");
  const auto characterised = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"characterise", "--yes", "--socket", daemon_.socket()});
    return run_eha(words, daemon_.folder());
  };
  const Ended unasked = characterised({});
  EXPECT_EQ(unasked.code, static_cast<int>(ExitCode::usage));
  EXPECT_NE(unasked.err.find("--ruler LENGTH"), std::string::npos) << unasked.err;
  const Ended differs = characterised({"--ruler", "1.2in"});
  EXPECT_EQ(differs.code, static_cast<int>(ExitCode::configuration));
  EXPECT_NE(differs.err.find("eha calibrate"), std::string::npos) << differs.err;
  EXPECT_EQ(rig_.card().enabled_ns, 0);
  const auto file = daemon_.folder() / "sheet.toml";
  std::ofstream(file) << "schema = 1\nname = \"sheet\"\n\n[characterise]\n";
  for (const char* way : {"--no-progress", "--detach"}) {
    const Ended run = run_eha({"run", file.string(), "--yes", way, "--socket", daemon_.socket()}, daemon_.folder());
    EXPECT_EQ(run.code, static_cast<int>(ExitCode::usage)) << run.out;
    EXPECT_NE(run.err.find("--ruler LENGTH"), std::string::npos) << run.err;
  }
  // Whoever speaks the protocol is asked as well.
  Client other(daemon_.socket());
  Json params{{"experiment", content_of(file)}, {"name", "sheet.toml"}};
  const Refused unread = refused(other, "submit", params);
  EXPECT_EQ(unread.code, static_cast<int>(ExitCode::usage));
  EXPECT_NE(unread.message.find("--ruler LENGTH"), std::string::npos) << unread.message;
  params["ruler_in"] = 1.2;
  EXPECT_EQ(refused(other, "submit", params).code, static_cast<int>(ExitCode::configuration));
  params["ruler_in"] = "2.95in";
  EXPECT_EQ(refused(other, "submit", params).code, static_cast<int>(ExitCode::usage));
  EXPECT_EQ(rig_.card().enabled_ns, 0);
  EXPECT_TRUE(other.call("queue").at("entries").empty());
  const Ended begun = interrupt_eha(
      {"characterise", "--yes", "--ruler", "74.9mm", "--socket", daemon_.socket()}, daemon_.folder(),
      [&] { return rig_.card().is_enabled(); }, SIGINT);
  EXPECT_EQ(begun.code, static_cast<int>(ExitCode::interrupted)) << begun.err;
}

TEST_F(ServiceArming, EndsWhereTheRodMovesWithTheHydraulicsOff) {
  start();
  client_->call("arm");
  ASSERT_EQ(client_->call("status").at("state"), "armed");
  rig_.card().position_in = 4.1;
  EXPECT_TRUE(daemon_.logs("the rod's reading moved by 1.1 in while nothing drove it")) << daemon_.log();
  const Json status = client_->call("status");
  EXPECT_NE(status.at("state"), "armed");
  EXPECT_NE(status.dump().find("while nothing drove it"), std::string::npos) << status;
}

/// CLOCK_MONOTONIC.
std::int64_t in_ns(std::chrono::milliseconds time) {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now + time).count();
}

/// Whether the hydraulics are off and the output at 0 V, within a generous time.
bool becomes_safe(const CardMemory& card) {
  constexpr std::uint32_t kHalf = 0x8000;
  const auto deadline = std::chrono::steady_clock::now() + kGenerous;
  const auto is_safe = [&] { return !card.is_enabled() && (card.output_code | 1U) == (kHalf | 1U); };
  while (!is_safe() && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return is_safe();
}

/// A loop that gives up after 20 ticks is over when the card takes writes again, or does not know that it never will.
TEST_F(ServiceArming, IsMadeSafeOnceACardTakesWritesAgain) {
  for (const int refused_ms : {60, 13'000}) {
    start();
    client_->call("arm");
    const std::int64_t entry = submit(*client_, quiet_experiment_text("driven", 60.0), false);
    ASSERT_TRUE(rig_.is_driven(3000));
    const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(refused_ms);
    const bool is_long = refused_ms > 1000;
    // However slow this machine is, the card still refuses when a stop is asked for.
    rig_.card().refuses_until_ns = in_ns(is_long ? std::chrono::hours(1) : std::chrono::milliseconds(refused_ms));
    EXPECT_EQ(follow(daemon_, entry).at("outcome"), "faulted");
    if (is_long) {
      ASSERT_TRUE(daemon_.logs("THE OUTPUT IS NOT CONFIRMED SAFE")) << daemon_.log();
      EXPECT_EQ(refused(*client_, "stop").code, static_cast<int>(ExitCode::device_unavailable));
      std::this_thread::sleep_until(until);
      rig_.card().refuses_until_ns = 0;
    }
    EXPECT_TRUE(becomes_safe(rig_.card())) << refused_ms << " ms\n" << daemon_.log();
    if (is_long) {
      EXPECT_TRUE(daemon_.logs("the output is safe now")) << daemon_.log();
    }
    client_->call("stop");
    EXPECT_EQ(client_->call("arm").at("state"), "armed") << daemon_.log();
    EXPECT_EQ(daemon_.stop(SIGTERM), 0);
    rig_.reset();
  }
}

/// eha-safe has given up on it, and the service was started anew.
TEST_F(ServiceArming, StartsBesideACardThatNobodyMadeSafeAndMakesItSafe) {
  start();
  client_->call("arm");
  const std::int64_t entry = submit(*client_, quiet_experiment_text("driven", 60.0), false);
  ASSERT_GT(entry, 0);
  ASSERT_TRUE(rig_.is_driven(3000));
  rig_.card().refuses_until_ns = in_ns(std::chrono::hours(1));
  ASSERT_EQ(kill(daemon_.pid(), SIGKILL), 0);
  static_cast<void>(daemon_.wait());
  ASSERT_TRUE(std::filesystem::exists(std::filesystem::path(daemon_.socket()).parent_path() / "safe.json"));
  daemon_.start();
  client_ = std::make_unique<Client>(daemon_.socket());
  EXPECT_EQ(refused(*client_, "stop").code, static_cast<int>(ExitCode::device_unavailable));
  EXPECT_TRUE(client_->call("status").at("rod").at("error").is_string()) << "nobody reads it";
  // Another rig file may name another card.
  std::ofstream(daemon_.rig_file(), std::ios::app) << "# another text\n";
  EXPECT_EQ(refused(*client_, "reload").code, static_cast<int>(ExitCode::device_unavailable));
  rig_.card().refuses_until_ns = 0;
  EXPECT_TRUE(becomes_safe(rig_.card())) << daemon_.log();
  ASSERT_TRUE(daemon_.logs("the output is safe now")) << daemon_.log();
  client_->call("reload");
  EXPECT_EQ(client_->call("arm").at("state"), "armed") << daemon_.log();
}

/// The snapshot names the card, not the rig file, which has another one by now, or none.
TEST_F(ServiceArming, MakesACardSafeThatItsRigFileNoLongerNames) {
  start();
  client_->call("arm");
  ASSERT_GT(submit(*client_, quiet_experiment_text("driven", 60.0), false), 0);
  ASSERT_TRUE(rig_.is_driven(3000));
  rig_.card().refuses_until_ns = in_ns(std::chrono::hours(1));
  ASSERT_EQ(kill(daemon_.pid(), SIGKILL), 0);
  static_cast<void>(daemon_.wait());
  std::ofstream(daemon_.rig_file()) << content_of(source_file("config/rigs/sim.toml"));
  daemon_.start();
  client_ = std::make_unique<Client>(daemon_.socket());
  EXPECT_EQ(refused(*client_, "stop").code, static_cast<int>(ExitCode::device_unavailable));
  EXPECT_EQ(refused(*client_, "arm").code, static_cast<int>(ExitCode::device_unavailable));
  rig_.card().refuses_until_ns = 0;
  EXPECT_TRUE(becomes_safe(rig_.card())) << daemon_.log();
  ASSERT_TRUE(daemon_.logs("the output is safe now")) << daemon_.log();
  EXPECT_EQ(client_->call("arm").at("state"), "armed") << "the simulated rig: " << daemon_.log();
}

TEST_F(ServiceArming, IsNotGivenUpByTheWatchdogWhileItsCardRefuses) {
  start();
  client_->call("arm");
  const std::int64_t entry = submit(*client_, quiet_experiment_text("driven", 60.0), false);
  ASSERT_TRUE(rig_.is_driven(3000));
  rig_.card().refuses_until_ns = in_ns(std::chrono::hours(1));
  EXPECT_EQ(follow(daemon_, entry).at("outcome"), "faulted");
  ASSERT_TRUE(daemon_.logs("THE OUTPUT IS NOT CONFIRMED SAFE")) << daemon_.log();
  // Closing the card takes two such calls, together longer than a loop may stand still in a run.
  rig_.card().output_stall_ms = 2000;
  rig_.card().refuses_until_ns = 0;
  ASSERT_TRUE(daemon_.logs("not confirmed safe: ")) << daemon_.log();
  // And so does each try from here on, alone.
  rig_.card().output_stall_ms = 4000;
  std::this_thread::sleep_for(std::chrono::seconds(9));
  EXPECT_EQ(daemon_.log().find("the loop stands still"), std::string::npos) << daemon_.log();
  rig_.card().output_stall_ms = 0;
  EXPECT_TRUE(daemon_.logs("the output is safe now")) << daemon_.log();
}

TEST_F(ServiceArming, IsNotTurnedToAnotherRigFileByAReloadWhileItsCardRefuses) {
  start();
  rig_.card().refuses_until_ns = in_ns(std::chrono::hours(1));
  const std::string before = content_of(daemon_.rig_file());
  std::ofstream(daemon_.rig_file()) << content_of(source_file("config/rigs/sim.toml"));
  EXPECT_EQ(refused(*client_, "reload").code, static_cast<int>(ExitCode::device_unavailable)) << "no card at all";
  std::ofstream(daemon_.rig_file()) << before << "# another text\n";
  // The first refusal shows as the card is closed.
  EXPECT_EQ(refused(*client_, "reload").code, static_cast<int>(ExitCode::device_unavailable));
  EXPECT_EQ(refused(*client_, "reload").code, static_cast<int>(ExitCode::device_unavailable));
  EXPECT_EQ(refused(*client_, "stop").code, static_cast<int>(ExitCode::device_unavailable));
  EXPECT_NE(client_->call("status").at("reason").get<std::string>().find("NOT CONFIRMED SAFE"), std::string::npos);
  rig_.card().refuses_until_ns = 0;
  ASSERT_TRUE(daemon_.logs("the output is safe now")) << daemon_.log();
  client_->call("reload");
  EXPECT_EQ(client_->call("arm").at("state"), "armed") << daemon_.log();
}

TEST_F(ServiceArming, IsMadeSafeByAStopWhateverItsState) {
  start();
  rig_.card().output_code = 40000;
  client_->call("stop");
  EXPECT_TRUE(becomes_safe(rig_.card()));
}

TEST_F(ServiceArming, TakesARulersReadingOfTheCalibrationThatItWasComparedWithOnly) {
  const std::string text = uncharacterised_rig();
  std::ofstream(daemon_.rig_file()) << text;
  for (const std::string& variable : rig_.environment()) daemon_.set_environment(variable);
  daemon_.start();
  Client client(daemon_.socket());
  const auto file = daemon_.folder() / "sheet.toml";
  std::ofstream(file) << "schema = 1\nname = \"sheet\"\n\n[characterise]\n";
  const Ended queued = run_eha(
      {"run", file.string(), "--yes", "--detach", "--ruler", "2.95in", "--socket", daemon_.socket()}, daemon_.folder());
  ASSERT_EQ(queued.code, 0) << queued.err;
  std::ofstream(daemon_.rig_file(), std::ios::app) << "# calibrated again\n";
  client.call("reload");
  client.call("arm");
  const std::int64_t entry = client.call("queue").at("entries").at(0).at("entry");
  client.call("release", {{"entry", entry}});
  const Json over = follow(daemon_, entry);
  EXPECT_EQ(over.at("outcome"), "refused");
  EXPECT_NE(over.at("note").get<std::string>().find("a ruler's reading"), std::string::npos) << over;
  EXPECT_EQ(rig_.card().enabled_ns, 0);
}

/// A line of a rig file that leaves a machine without protection, and the value that would do.
struct BadLine {
  std::string sound;
  std::string bad;
  std::string remedy;
};

void PrintTo(const BadLine& line, std::ostream* stream) { *stream << line.bad; }

class ServiceArmingWith : public ServiceArming, public ::testing::WithParamInterface<BadLine> {};

TEST_P(ServiceArmingWith, IsRefusedWithTheValueThatWouldDo) {
  start(GetParam().sound, GetParam().bad);
  const Refused answer = refused(*client_, "arm");
  EXPECT_EQ(answer.code, static_cast<int>(ExitCode::configuration));
  EXPECT_NE(answer.message.find("not armed: "), std::string::npos) << answer.message;
  EXPECT_NE(answer.message.find(GetParam().remedy), std::string::npos) << answer.message;
  EXPECT_EQ(client_->call("status").at("state"), "faulted");
}

INSTANTIATE_TEST_SUITE_P(
    LimitsThatProtectFromNothing, ServiceArmingWith,
    ::testing::Values(BadLine{"safe_V = 0.0 ", "safe_V = 4.9 ", "set 0, within 0.5 V"},
                      BadLine{"velocity_limit_in_per_s = 8.0 ", "velocity_limit_in_per_s = 1e9 ", "at most 56"},
                      BadLine{"slew_V_per_s = 20.0 ", "slew_V_per_s = 1e9 ", "at most 1e+03"},
                      BadLine{"dead_band_V = 0.3 ", "dead_band_V = 3.0 ", "at most 1.5"},
                      BadLine{"abort_consecutive_late = 1000 ", "abort_consecutive_late = 1000000 ", "at most 1000,"},
                      BadLine{"abort_total_late = 10000 ", "abort_total_late = 1000000 ", "at most 10000,"},
                      BadLine{"# no sample ", "sample = true ", "remove this line"},
                      BadLine{"open_circuit_V = 10.0 ", "open_circuit_V = 0.0 ", "bias the input to a rail"}));

}  // namespace
}  // namespace eha::test
