// SPDX-License-Identifier: GPL-3.0-or-later
// Where the rod is, with and without the service, on the simulated rig.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "core/error.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

using control::Client;

/// The rod as the service sees it, once it has been read often enough for its noise.
Json rod_of(Client& client) {
  for (int i = 0; i < 1000; ++i) {
    Json rod = client.call("status").at("rod");
    if (rod.is_object() && rod.at("noise_in").is_number()) return rod;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return nullptr;
}

TEST(Read, SeesTheRodOfARigThatIsNotDriven) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  const Json rod = rod_of(client);
  ASSERT_TRUE(rod.is_object());
  EXPECT_NEAR(rod.at("displacement_in").get<double>(), 2.95, 0.01);
  EXPECT_NEAR(rod.at("feedback_V").get<double>(), 2.95 / 0.6, 0.02);
  EXPECT_NEAR(rod.at("noise_in").get<double>(), 0.0006, 0.0005);
  EXPECT_EQ(rod.at("travel_min_in"), 0.15);
  EXPECT_EQ(rod.at("near_limit"), false);
  EXPECT_EQ(client.call("status").at("state"), "faulted") << "reading arms nothing";

  const Ended read = run_eha({"read", "--socket", daemon.socket()}, daemon.folder());
  EXPECT_EQ(read.code, 0) << read.err;
  EXPECT_NE(read.out.find("rod      2.9"), std::string::npos) << read.out;
  EXPECT_NE(read.out.find("not armed (ehad has started)"), std::string::npos) << read.out;
  const Ended status = run_eha({"status", "--socket", daemon.socket()}, daemon.folder());
  EXPECT_NE(status.out.find("0.150 [===="), std::string::npos) << status.out;
}

TEST(Check, LeadsFromAFileOfVoltsToALocalRun) {
  Daemon daemon;
  daemon.start();
  const std::string socket = daemon.socket().string();
  std::string volts = "voltage_V\n";
  for (int tick = 0; tick < 4000; ++tick) volts += fmt::format("{}\n", 1e-3 * std::min(tick, 4000 - tick));
  std::ofstream(daemon.folder() / "volts.csv") << volts;
  std::ofstream(daemon.folder() / "steps.toml")
      << "schema = 1\nname = \"steps\"\nduration_s = 4.0\n[excitation]\nkind = \"table\"\nfile = \"volts.csv\"\n";
  const std::string reason =
      "steps.toml:6:8: excitation.file: \"volts.csv\" is not sent with the experiment: the service receives the "
      "experiment's text only; play it with --local";
  for (const char* command : {"check", "design"}) {
    const Ended ended = run_eha({command, "steps.toml", "--socket", socket}, daemon.folder());
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_NE(ended.err.find(reason), std::string::npos) << ended.err;
    EXPECT_NE(ended.out.find("Next: eha run steps.toml --local --fast --rig rig.toml\n"), std::string::npos)
        << ended.out;
  }
}

TEST(Design, IsForTheRigOfTheService) {
  Daemon daemon;
  std::string rig = content_of(daemon.rig_file());
  const std::string limit = "command_max_V = 5.0 ";
  rig.replace(rig.find(limit), limit.size(), "command_max_V = 1.0 ");
  std::ofstream(daemon.rig_file()) << rig;
  daemon.start();
  const std::string socket = daemon.socket().string();
  const std::string file = daemon.rig_file().string();
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--odd-random"}}) {
    std::vector<std::string> words{"design", "--band", "0.1:1", "--socket", socket};
    words.insert(words.end(), more.begin(), more.end());
    const Ended made = run_eha(words, daemon.folder());
    EXPECT_EQ(made.code, 0) << made.err;
    EXPECT_NE(made.out.find("written: band.toml, for the limits of " + file + ", the rig of the service; --rig names"),
              std::string::npos)
        << made.out;
    EXPECT_NE(made.out.find(fmt::format("Next: eha arm --socket {0} && eha run band.toml --socket {0}\n", socket)),
              std::string::npos)
        << made.out;
  }
  Client(socket).call("arm");
  EXPECT_NE(run_eha({"check", "band.toml", "--socket", socket}, daemon.folder()).out.find("Next: eha run band.toml"),
            std::string::npos)
      << "it is armed already";
  const Ended shown = run_eha({"design", "band.toml", "--socket", socket}, daemon.folder());
  EXPECT_NE(shown.out.find("for the limits of " + file + ", the rig of the service"), std::string::npos) << shown.out;
  EXPECT_NE(shown.out.find("(rig: -5..1 V)"), std::string::npos) << shown.out;
  const Ended named =
      run_eha({"design", "--band", "0.1:1", "--rig", source_file("config/rigs/sim.toml")}, daemon.folder());
  EXPECT_EQ(named.out.find("of the service"), std::string::npos) << named.out;
  std::ofstream(daemon.rig_file(), std::ios::app) << "# a remark\n";
  const Ended edited = run_eha({"design", "--band", "0.1:1", "--socket", socket}, daemon.folder());
  EXPECT_EQ(edited.code, static_cast<int>(ExitCode::usage)) << edited.out;
  EXPECT_NE(edited.err.find("put it in force with eha reload, or name a rig file with --rig"), std::string::npos)
      << edited.err;
}

TEST(Read, RefusesAnotherRigWhereTheNamedServiceIsGone) {
  const std::string said = output_of_shell("EHA_SOCKET=/nowhere/ehad.sock " EHA_PROGRAM " read 2>&1; echo code $?");
  EXPECT_NE(said.find("/nowhere/ehad.sock"), std::string::npos) << said;
  EXPECT_EQ(said.find("rod "), std::string::npos) << said;
  EXPECT_EQ(said.find("code 0"), std::string::npos) << said;
}

/// Arms, and returns the entry of a run of 600 s, once it is on.
std::int64_t long_run(const Daemon& daemon, Client& client) {
  client.call("arm");
  const std::int64_t entry = submit(client, quiet_experiment_text("long", 600.0), false);
  follow(daemon, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  return entry;
}

TEST(Read, SeesTheRodWhileARunIsOn) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  const std::int64_t entry = long_run(daemon, client);
  const Json rod = client.call("status").at("rod");
  EXPECT_NEAR(rod.at("displacement_in").get<double>(), 2.95, 0.2);
  EXPECT_NEAR(rod.at("feedback_V").get<double>() * 0.6, rod.at("displacement_in").get<double>(), 1e-9);
  EXPECT_GT(rod.at("feedback_code").get<int>(), 32768);
  client.call("stop");
  EXPECT_EQ(follow(daemon, entry).at("outcome"), "interrupted");
}

TEST(Calibrate, GoesOnAskingWhenARunComesBetween) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  const std::int64_t entry = long_run(daemon, client);
  const std::string said = output_of_shell("printf '75mm\\n50mm\\n\\n' | " EHA_PROGRAM " calibrate --socket " +
                                           daemon.socket().string() + " 2>&1");
  client.call("stop");
  EXPECT_NE(said.find("not taken: a run is on; the 0 readings before it are kept"), std::string::npos) << said;
  EXPECT_EQ(lines_beginning_with(said, "position 1 [in]: eha: warning: not taken"), 2U) << said;
  EXPECT_EQ(follow(daemon, entry).at("outcome"), "interrupted");
}

TEST(Run, SaysAtOnceThatTheRigIsNotArmedAndHowToArmIt) {
  Daemon daemon;
  daemon.start();
  const std::filesystem::path file = daemon.folder() / "e.toml";
  std::ofstream(file) << experiment_text("held");
  const std::string socket = daemon.socket().string();
  const std::string said =
      output_of_shell("timeout -s INT 3 " EHA_PROGRAM " run " + file.string() + " --socket " + socket + " 2>&1");
  EXPECT_NE(said.find("the rig is not armed, and experiment 1 is held; in another terminal: `eha arm --socket " +
                      socket + " && eha queue release 1 --socket " + socket + "`"),
            std::string::npos)
      << said;
}

TEST(Read, ReadsALocalRigOnceAndTheOneOfTheEnvironmentsSocket) {
  Daemon daemon;
  daemon.start();
  const Ended local = run_eha({"read", "--local", "--rig", daemon.rig_file(), "--json"}, daemon.folder());
  EXPECT_EQ(local.code, 0) << local.err;
  const Json read = Json::parse(local.out);
  EXPECT_EQ(read.at("state"), "not driven");
  EXPECT_NEAR(read.at("rod").at("displacement_in").get<double>(), 2.95, 0.01);
  setenv("EHA_SOCKET", daemon.socket().c_str(), 1);
  const Ended served = run_eha({"read", "--json"}, daemon.folder());
  unsetenv("EHA_SOCKET");
  EXPECT_EQ(served.code, 0) << served.err;
  EXPECT_EQ(Json::parse(served.out).at("state"), "faulted");
}

}  // namespace
}  // namespace eha::test
