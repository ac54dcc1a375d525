// SPDX-License-Identifier: GPL-3.0-or-later
// The rod to a place, through the service and without it, on the simulated rig.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/error.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;

constexpr const char* kGoTo = "schema = 1\nname = \"goto\"\nduration_s = 60.0\n[place]\ndisplacement_in = 4.5\n";

class ServicePlace : public ::testing::Test {
 protected:
  void SetUp() override { daemon_.start(); }

  Ended eha(std::vector<std::string> words) {
    words.insert(words.end(), {"--socket", daemon_.socket()});
    return run_eha(words, daemon_.folder());
  }

  double rod_in() { return Json::parse(eha({"read", "--json"}).out).at("rod").at("displacement_in").get<double>(); }

  Daemon daemon_;
};

TEST_F(ServicePlace, MovesTheRodThereAndAgainRelativeToIt) {
  Client(daemon_.socket()).call("arm");
  const Ended there = eha({"goto", "4in", "--fast"});
  ASSERT_EQ(there.code, 0) << there.err;
  EXPECT_NE(there.out.find("the rod is at "), std::string::npos) << there.out;
  EXPECT_NEAR(rod_in(), 4.0, 0.03);
  const Ended back = eha({"jog", "-5.08mm", "--fast", "--json"});
  ASSERT_EQ(back.code, 0) << back.err;
  EXPECT_NEAR(rod_in(), 3.8, 0.05);
  const Json run = Json::parse(back.out);
  EXPECT_EQ(run.at("outcome"), "completed");
  const fs::path folder = run.at("run").get<std::string>();
  EXPECT_TRUE(fs::exists(folder / "raw.h5")) << "a placing is recorded as a run";
  const Json manifest = Json::parse(content_of(folder / "run.json"));
  EXPECT_NEAR(manifest.at("experiment").at("place_in").get<double>(), 3.8, 0.03);
  EXPECT_TRUE(fs::is_empty(folder / "models")) << "there is nothing to fit";
  const Ended shown = eha({"runs", "show", folder});
  EXPECT_NE(shown.out.find("Next: eha plot "), std::string::npos) << shown.out;
  const Ended fitted = run_eha({"fit", folder}, daemon_.folder());
  EXPECT_EQ(fitted.code, static_cast<int>(ExitCode::bad_data)) << fitted.err;
  EXPECT_NE(fitted.err.find("a move of the rod to a place"), std::string::npos) << fitted.err;
  const Ended list = eha({"runs", "list", "--all"});
  EXPECT_NE(list.out.find("a move to a place"), std::string::npos) << list.out;
  EXPECT_EQ(list.out.find("not fitted"), std::string::npos) << list.out;
  EXPECT_EQ(Client(daemon_.socket()).call("status").at("state"), "armed") << "the next may follow";
}

TEST_F(ServicePlace, NamesTheMeasurementOfTheValveFirst) {
  EXPECT_NE(eha({"arm"}).out.find("Next: eha check "), std::string::npos);
  std::string rig = content_of(daemon_.rig_file());
  const std::size_t following = rig.find("\n[following]");
  ASSERT_NE(following, std::string::npos) << rig;
  rig.erase(following, rig.find("\n[", following + 1) - following);
  std::ofstream(daemon_.rig_file()) << rig;
  EXPECT_NE(eha({"arm"}).out.find(fmt::format("Next: eha disarm --socket {0} && eha reload --socket {0} && eha arm "
                                              "--socket {0}\n",
                                              daemon_.socket().string())),
            std::string::npos)
      << "the file is not what is in force";
  ASSERT_EQ(eha({"disarm"}).code, 0);
  const std::string paper = EHA_SOURCE_DIR "/config/experiments/paper.toml";
  const Ended early = eha({"check", paper});
  EXPECT_EQ(early.code, static_cast<int>(ExitCode::usage)) << "another rig is in force";
  EXPECT_NE(early.err.find("edited since ehad read it"), std::string::npos) << early.err;
  EXPECT_NE(eha({"status"}).out.find("until eha reload"), std::string::npos);
  ASSERT_EQ(eha({"reload"}).code, 0);
  EXPECT_EQ(eha({"status"}).out.find("until eha reload"), std::string::npos);
  const Ended armed = eha({"arm"});
  EXPECT_NE(armed.out.find("Next: eha characterise"), std::string::npos) << armed.out << armed.err;
  EXPECT_NE(armed.err.find("no [following] in the rig file"), std::string::npos) << armed.out << armed.err;
}

TEST_F(ServicePlace, LeadsFromACheckedRigFileToTheService) {
  const std::string other = (daemon_.folder() / "rig-new.toml").string();
  fs::copy_file(daemon_.rig_file(), other);
  const Ended checked = eha({"check", other});
  ASSERT_EQ(checked.code, 0) << checked.err;
  EXPECT_NE(checked.out.find("&& cp " + other), std::string::npos) << "this user may write the file\n" << checked.out;
  EXPECT_NE(checked.out.find("eha reload --socket " + daemon_.socket().string() + " && eha arm"), std::string::npos)
      << checked.out;
  std::ofstream(daemon_.rig_file(), std::ios::app) << "# a remark\n";
  const Ended own = eha({"check", daemon_.rig_file()});
  EXPECT_EQ(own.out.find(" cp "), std::string::npos) << own.out;
  EXPECT_NE(own.out.find("eha reload"), std::string::npos) << own.out;
}

TEST_F(ServicePlace, CharacterisesTheValve) {
  Client(daemon_.socket()).call("arm");
  const Ended ended = eha({"characterise", "--fast", "--json"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  const Json sheet = Json::parse(ended.out);
  EXPECT_EQ(sheet.at("schema"), "eha-valve-sheet/1");
  EXPECT_NEAR(sheet.at("null_V").at("value").get<double>(), -0.2, 0.01);
  const fs::path folder = sheet.at("run").get<std::string>();
  EXPECT_TRUE(fs::exists(folder / "valve_sheet.json")) << "written by the service";
  EXPECT_TRUE(fs::is_empty(folder / "models"));
}

TEST_F(ServicePlace, RefusesPlacesOutsideTheTravelAndLengthsWithoutAUnit) {
  Client(daemon_.socket()).call("arm");
  const Ended outside = eha({"goto", "5.74in", "--fast"});
  EXPECT_EQ(outside.code, static_cast<int>(ExitCode::configuration));
  EXPECT_NE(outside.err.find("goto 5.74in: 5.74 in is too near to the travel limit of 5.75 in"), std::string::npos)
      << outside.err;
  const Ended beyond = eha({"goto", "200mm", "--fast"});
  EXPECT_NE(beyond.err.find("goto 200mm: 200 mm is beyond the travel limits of the rig, 3.81 to 146.05 mm"),
            std::string::npos)
      << "in the unit that was typed: " << beyond.err;
  const Ended at_limit = eha({"goto", "146.05mm", "--fast"});
  EXPECT_NE(at_limit.err.find("146.05 mm is too near to the travel limit of 146.05 mm"), std::string::npos)
      << at_limit.err;
  EXPECT_EQ(eha({"jog", "+9in", "--fast"}).code, static_cast<int>(ExitCode::configuration));
  const Ended little = eha({"jog", "+0.1mm", "--fast"});
  EXPECT_EQ(little.code, 0) << little.err;
  EXPECT_NE(little.err.find("where a placing ends: it may not move"), std::string::npos) << little.err;
  EXPECT_EQ(eha({"goto", "3"}).code, static_cast<int>(ExitCode::usage));
  EXPECT_NEAR(rod_in(), 2.95, 0.01);
}

TEST_F(ServicePlace, RampsOutOnAStopAndRefusesToJogMeanwhile) {
  Client client(daemon_.socket());
  client.call("arm");
  const std::int64_t entry = submit(client, kGoTo, false);
  follow(daemon_, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  EXPECT_EQ(eha({"jog", "+0.1in"}).code, static_cast<int>(ExitCode::usage));
  EXPECT_EQ(client.call("stop").at("stopped"), "ramping_out");
  const Json over = follow(daemon_, entry);
  EXPECT_EQ(over.at("outcome"), "interrupted");
  EXPECT_EQ(client.call("status").at("state"), "idle");
}

TEST_F(ServicePlace, MovesNothingForAUserWhoDoesNotHoldTheLease) {
  if (!can_change_user()) GTEST_SKIP() << "needs two users";
  daemon_.open_to_all();
  const auto alice = connect_as(65534, daemon_);
  const auto bob = connect_as(1, daemon_);
  const Json goes{{"experiment", kGoTo}, {"name", "goto"}};
  EXPECT_EQ(refused(*bob, "submit", goes).code, static_cast<int>(ExitCode::permission)) << "nobody has armed";
  alice->call("arm");
  const Refused other = refused(*bob, "submit", goes);
  EXPECT_EQ(other.code, static_cast<int>(ExitCode::permission));
  EXPECT_NE(other.message.find("goto: the lease is nobody's for another"), std::string::npos) << other.message;
  EXPECT_TRUE(alice->call("queue").at("entries").empty()) << "a move does not wait until somebody arms";
  EXPECT_NEAR(rod_in(), 2.95, 0.01);
}

TEST_F(ServicePlace, StartsAnExperimentWhereItAsksAndHoldsItThere) {
  Client client(daemon_.socket());
  client.call("arm");
  const std::string text = experiment_text("started") + "\n[start]\ndisplacement_in = 2.0\n\n[hold]\n";
  const Json over = follow(daemon_, submit(client, text),
                           [](const Json& snapshot) { return snapshot.at("entry").at("state") == "fitting"; });
  EXPECT_EQ(over.at("outcome"), "completed") << over;
  const Json manifest = Json::parse(content_of(fs::path(over.at("folder").get<std::string>()) / "run.json"));
  EXPECT_EQ(manifest.at("experiment").at("start_in"), 2.0);
  EXPECT_TRUE(manifest.at("experiment").at("hold").is_object());
  EXPECT_EQ(over.at("placed_in"), nullptr);
}

TEST_F(ServicePlace, RampsOutOnAStopOfAHeldExperiment) {
  Client client(daemon_.socket());
  client.call("arm");
  const std::int64_t entry = submit(client, quiet_experiment_text("held", 40.0) + "\n[hold]\n", false);
  follow(daemon_, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  EXPECT_EQ(client.call("stop").at("stopped"), "ramping_out");
  EXPECT_EQ(follow(daemon_, entry).at("outcome"), "interrupted");
  EXPECT_EQ(client.call("status").at("state"), "idle");
}

TEST_F(ServicePlace, LetsAnyUserStopARodThatAnotherOneMoves) {
  if (!can_change_user()) GTEST_SKIP() << "needs two users";
  daemon_.open_to_all();
  const auto alice = connect_as(65534, daemon_);
  const auto bob = connect_as(1, daemon_);
  alice->call("arm");
  const std::int64_t entry = submit(*alice, kGoTo, false);
  follow(daemon_, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  EXPECT_EQ(bob->call("stop").at("stopped"), "ramping_out");
  EXPECT_EQ(follow(daemon_, entry).at("outcome"), "interrupted");
}

TEST_F(ServicePlace, TripsOnASensorThatDoesNotFollow) {
  // The valve passes nothing: the sensor stays where it is, as a torn wire does.
  std::string rig = content_of(daemon_.rig_file());
  const std::string dead_band = "valve_dead_band_V = 0.15";
  rig.replace(rig.find(dead_band), dead_band.size(), "valve_dead_band_V = 4.9");
  std::ofstream(daemon_.rig_file()) << rig;
  Client client(daemon_.socket());
  client.call("reload");
  client.call("arm");
  const Ended jog = eha({"jog", "+0.4in", "--fast"});
  EXPECT_EQ(jog.code, static_cast<int>(ExitCode::safety_trip)) << jog.err;
  EXPECT_NE(jog.err.find("no_motion"), std::string::npos) << jog.err;
  EXPECT_NE(jog.err.find("` measures both"), std::string::npos) << jog.err;
  EXPECT_NE(jog.out.find("Next: eha read --socket " + daemon_.socket().string() + "\n"), std::string::npos)
      << jog.out << "whoever copies the next step after a trip moves nothing";
  EXPECT_NE(jog.err.find("the rig is disarmed"), std::string::npos) << jog.err;
  EXPECT_EQ(client.call("status").at("state"), "faulted");
  const Ended again = eha({"jog", "+0.4in", "--fast"});
  EXPECT_EQ(again.code, static_cast<int>(ExitCode::permission)) << again.err;
  EXPECT_NE(again.err.find("faulted: no_motion"), std::string::npos) << again.err << "why it is not armed";
  std::ofstream(daemon_.folder() / "quiet.toml") << quiet_experiment_text("quiet", 2.0);
  const Ended detached = eha({"run", (daemon_.folder() / "quiet.toml").string(), "--fast", "--detach"});
  EXPECT_NE(detached.err.find("faulted: no_motion"), std::string::npos) << detached.err;
}

TEST_F(ServicePlace, SaysHowTheValveIsMeasuredWhereAWrongNullEndsTheMeasurement) {
  std::string rig = content_of(daemon_.rig_file());
  const std::string null = "\nnull_V = -0.2 ";
  std::ofstream(daemon_.rig_file()) << rig.replace(rig.find(null), null.size(), "\nnull_V = 0.9 ");
  Client client(daemon_.socket());
  client.call("reload");
  client.call("arm");
  const Ended ended = eha({"characterise", "--fast"});
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::safety_trip)) << ended.err;
  EXPECT_NE(ended.err.find("a wrong [following] of " + daemon_.rig_file().string()), std::string::npos) << ended.err;
  EXPECT_NE(ended.err.find("the run ended before its first row"), std::string::npos) << ended.err;
}

TEST_F(ServicePlace, BringsBackARodBeyondALimitOnlyWhenItWasSeenThere) {
  std::string rig = content_of(daemon_.rig_file());
  const std::string start = "initial_displacement_in = 2.95";
  rig.replace(rig.find(start), start.size(), "initial_displacement_in = 5.85");
  std::ofstream(daemon_.rig_file()) << rig;
  Client client(daemon_.socket());
  client.call("reload");
  client.call("arm");
  // Whatever is asked, the answer is the way back.
  const std::string way = "eha goto 2.95in";
  EXPECT_NE(eha({"arm"}).out.find("Next: " + way), std::string::npos) << eha({"arm"}).out;
  const Ended read = eha({"read"});
  EXPECT_NE(read.out.find("beyond the upper travel limit of 5.750 in: look at the rod"), std::string::npos) << read.out;
  EXPECT_NE(read.out.find("Next: " + way), std::string::npos) << read.out;
  std::ofstream(daemon_.folder() / "e.toml") << experiment_text("waits");
  for (const bool accepts : {false, true}) {
    const Ended run = eha({"run", "e.toml", "--fast", accepts ? "--accept-travel-risk" : "--detach"});
    EXPECT_EQ(run.code, static_cast<int>(ExitCode::configuration)) << run.err;
    EXPECT_NE(run.err.find("beyond the upper travel limit of 5.750 in"), std::string::npos) << run.err;
    EXPECT_NE(run.err.find(way), std::string::npos) << run.err;
  }
  const Ended unseen = eha({"goto", "2.95in", "--fast", "--yes"});
  EXPECT_EQ(unseen.code, static_cast<int>(ExitCode::usage)) << unseen.err;
  EXPECT_NE(unseen.err.find("--way-back"), std::string::npos) << unseen.err;
  EXPECT_NEAR(rod_in(), 5.85, 0.01) << "nothing was moved";
  std::ofstream(daemon_.folder() / "w.toml")
      << "schema = 1\nname = \"w\"\nduration_s = 60.0\n[place]\ndisplacement_in = 2.95\nway_back = true\n";
  const Ended unasked_file = eha({"run", "w.toml", "--fast", "--yes"});
  EXPECT_EQ(unasked_file.code, static_cast<int>(ExitCode::usage)) << unasked_file.err;
  EXPECT_NE(unasked_file.err.find("`eha goto` asks"), std::string::npos) << unasked_file.err;
  const std::int64_t unasked = submit(client, kGoTo);
  EXPECT_EQ(follow(daemon_, unasked).at("outcome"), "faulted") << "a placing that nobody was asked about trips";
  client.call("arm");
  const Ended back = eha({"goto", "2.95in", "--fast", "--yes", "--way-back", "--json"});
  ASSERT_EQ(back.code, 0) << back.err;
  EXPECT_NEAR(rod_in(), 2.95, 0.03);
  EXPECT_EQ(back.err.find("lower the excitation"), std::string::npos) << "it was the way back: " << back.err;
  EXPECT_NE(eha({"arm"}).out.find("Next: eha check "), std::string::npos);
}

TEST_F(ServicePlace, MovesALocalRigToo) {
  const Ended there =
      run_eha({"goto", "75mm", "--local", "--fast", "--rig", daemon_.rig_file(), "--json"}, daemon_.folder());
  ASSERT_EQ(there.code, 0) << there.err;
  const Json run = Json::parse(there.out);
  EXPECT_NEAR(run.at("displacement_in").get<double>(), 75.0 / 25.4, 0.02);
  EXPECT_EQ(run.at("outcome"), "completed");
}

TEST_F(ServicePlace, EndsALocalTripWithWhatToDo) {
  std::string rig = content_of(daemon_.rig_file());
  const std::string null = "null_V = -0.2 ";
  rig.replace(rig.find(null), null.size(), "null_V = 0.9 ");
  daemon_.stop(SIGTERM);
  std::ofstream(daemon_.rig_file()) << rig;
  const Ended ended = run_eha({"goto", "60mm", "--local", "--fast", "--rig", daemon_.rig_file()}, daemon_.folder());
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::safety_trip)) << ended.err;
  // A measurement with the same [following] would trip like it.
  const std::string next = "Next: eha characterise --without-following -o rig-bare.toml --local --fast --rig " +
                           daemon_.rig_file().string() + "\n";
  EXPECT_NE(ended.out.find(next), std::string::npos) << ended.out;
  const Ended sheet = run_eha({"characterise", "--local", "--fast", "--rig", daemon_.rig_file()}, daemon_.folder());
  EXPECT_EQ(sheet.code, static_cast<int>(ExitCode::safety_trip)) << sheet.err;
  EXPECT_NE(sheet.out.find(next), std::string::npos) << sheet.out;
  std::error_code none;
  int shown = 0;
  for (const auto& entry : fs::directory_iterator(daemon_.folder() / "runs", none)) {
    if (entry.is_symlink()) continue;
    ++shown;
    const Ended show = run_eha({"runs", "show", entry.path().string()}, daemon_.folder());
    EXPECT_NE(show.out.find("Next: eha characterise --without-following -o rig-bare"), std::string::npos)
        << "as after the run: " << show.out;
  }
  EXPECT_EQ(shown, 2);
  const auto step = [&](const std::vector<std::string>& words) {
    const Ended played = run_eha(words, daemon_.folder());
    EXPECT_EQ(played.code, 0) << played.err;
    return played.out;
  };
  EXPECT_NE(step({"characterise", "--without-following", "-o", "rig-bare.toml", "--local", "--fast", "--rig",
                  daemon_.rig_file()})
                .find("Next: eha characterise -o rig-new.toml --local --fast --rig rig-bare.toml\n"),
            std::string::npos);
  (void)step({"characterise", "-o", "rig-new.toml", "--local", "--fast", "--rig", "rig-bare.toml"});
  (void)step({"goto", "60mm", "--local", "--fast", "--rig", "rig-new.toml"});
}

TEST_F(ServicePlace, NamesTheRigOfARodBeyondALimit) {
  std::string rig = content_of(daemon_.rig_file());
  const std::string start = "initial_displacement_in = 2.95 ";
  rig.replace(rig.find(start), start.size(), "initial_displacement_in = 5.85 ");
  std::ofstream(daemon_.folder() / "beyond.toml") << rig;
  const Ended ended = run_eha({"goto", "60mm", "--local", "--fast", "--rig", "beyond.toml"}, daemon_.folder());
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::usage)) << ended.err;
  EXPECT_NE(ended.err.find("`eha read --local --rig beyond.toml`, `eha calibrate --local --rig beyond.toml`"),
            std::string::npos)
      << ended.err;
}

TEST_F(ServicePlace, NamesTheNewestSheetWhereAnotherNullTripped) {
  Client(daemon_.socket()).call("arm");
  const Ended measured = eha({"characterise", "--fast", "--json"});
  ASSERT_EQ(measured.code, 0) << measured.err;
  const fs::path sheet = Json::parse(measured.out).at("run").get<std::string>();
  std::string rig = content_of(daemon_.rig_file());
  const std::string null = "null_V = -0.2 ";
  rig.replace(rig.find(null), null.size(), "null_V = 0.9 ");
  ASSERT_EQ(eha({"disarm"}).code, 0);
  std::ofstream(daemon_.rig_file()) << rig;
  ASSERT_EQ(eha({"reload"}).code, 0);
  ASSERT_EQ(eha({"arm"}).code, 0);
  const Ended tripped = eha({"goto", "60mm", "--fast"});
  EXPECT_EQ(tripped.code, static_cast<int>(ExitCode::safety_trip)) << tripped.err;
  EXPECT_NE(tripped.err.find("after the valve sheet of "), std::string::npos) << tripped.err;
  EXPECT_NE(tripped.out.find("Next: eha characterise " + sheet.string() + " -o rig-new.toml"), std::string::npos)
      << tripped.out;
  EXPECT_EQ(tripped.out.find("Next: "), tripped.out.rfind("Next: ")) << tripped.out;
  const Ended listed = eha({"runs", "list", "--all", "--json"});
  ASSERT_EQ(listed.code, 0) << listed.err;
  const Ended show = eha({"runs", "show", Json::parse(listed.out).at("runs").back().at("folder").get<std::string>()});
  EXPECT_NE(show.out.find("Next: eha characterise " + sheet.string() + " -o rig-new.toml"), std::string::npos)
      << "as after the run: " << show.out;
}

}  // namespace
}  // namespace eha::test
