// SPDX-License-Identifier: GPL-3.0-or-later
// Several experiments at once, and the queue by hand: hold, release, move, cancel.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "core/error.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;

constexpr uid_t kAlice = 65534;  // nobody
constexpr uid_t kBob = 1;        // daemon

/// One that drives the rod away, as the rehearsal tells.
constexpr const char* kDrifts =
    "schema = 1\nname = \"drifts\"\nduration_s = 60.0\n[excitation]\nkind = \"sine\"\noffset_V = 0.8\n"
    "tones = [{ frequency_Hz = 0.2, amplitude_V = 2.0 }]\n[record]\ndiscard_s = 0.0\n[[model]]\nname = \"io\"\n"
    "structure = \"io\"\n";

class ServiceQueue : public ::testing::Test {
 protected:
  void SetUp() override {
    daemon_.start();
    for (const char* name : {"a", "b", "c"}) {
      std::ofstream(daemon_.folder() / (std::string(name) + ".toml")) << quiet_experiment_text(name, 2.0);
    }
  }

  Ended eha(std::vector<std::string> words) {
    words.insert(words.end(), {"--socket", daemon_.socket()});
    return run_eha(words, daemon_.folder());
  }

  /// The numbers of those that are held or wait, as the queue lists them.
  std::vector<std::int64_t> queued() {
    std::vector<std::int64_t> numbers;
    const Json queue = Client(daemon_.socket()).call("queue");
    for (const Json& entry : queue.at("entries")) {
      if (entry.at("state") == "held" || entry.at("state") == "waiting") numbers.push_back(entry.at("entry"));
    }
    return numbers;
  }

  Daemon daemon_;
};

TEST_F(ServiceQueue, TakesSeveralExperimentsOrNone) {
  std::ofstream(daemon_.folder() / "broken.toml") << "schema = 1\nname = \"broken\"\n";
  const Ended refused = eha({"run", "a.toml", "broken.toml", "--detach"});
  EXPECT_EQ(refused.code, static_cast<int>(ExitCode::configuration));
  EXPECT_NE(refused.err.find("broken.toml"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("none of the 2 experiments was queued"), std::string::npos) << refused.err;
  EXPECT_TRUE(queued().empty());
  const Ended missing = eha({"run", "a.toml", "missing.toml", "--detach"});
  EXPECT_NE(missing.err.find("none of the 2 experiments was queued"), std::string::npos) << missing.err;
  std::ofstream(daemon_.folder() / "record.csv") << "time_s,u_V,y_in\n0,1,2\n1,2,3\n2,1,2\n";
  const Ended record = eha({"run", "a.toml", "record.csv", "--detach"});
  EXPECT_NE(record.err.find("is a record"), std::string::npos) << record.err;
  EXPECT_NE(record.err.find("none of the 2 experiments was queued"), std::string::npos) << record.err;
  const Ended alone = eha({"run", "broken.toml", "--detach"});
  EXPECT_EQ(alone.err.find("none of the"), std::string::npos) << alone.err;
  const Ended taken = eha({"run", "a.toml", "b.toml", "c.toml", "--detach", "--units", "mm"});
  ASSERT_EQ(taken.code, 0) << taken.err;
  EXPECT_EQ(queued().size(), 3U);
  EXPECT_NE(taken.out.find("\"b\" is held\n"), std::string::npos) << taken.out;
  EXPECT_NE(taken.out.find("Next: eha arm --socket " + daemon_.socket().string() + " --units mm\n"), std::string::npos)
      << taken.out;
}

TEST_F(ServiceQueue, SaysWhatBecomesOfTheRestOfAListAfterATrip) {
  std::ofstream(daemon_.folder() / "drifts.toml") << kDrifts;
  ASSERT_EQ(eha({"arm"}).code, 0);
  const Ended ended = eha({"run", "drifts.toml", "a.toml", "b.toml", "--fast", "--accept-travel-risk"});
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::safety_trip)) << ended.err;
  const std::vector<std::int64_t> rest = queued();
  ASSERT_EQ(rest.size(), 2U) << ended.out << ended.err;
  const std::string numbers = std::to_string(rest[0]) + " " + std::to_string(rest[1]);
  EXPECT_NE(ended.err.find("not played, and held"), std::string::npos) << ended.err;
  for (const char* command : {"eha queue release ", "eha queue cancel "}) {
    EXPECT_NE(ended.err.find(command + numbers), std::string::npos) << ended.err;
  }
}

TEST_F(ServiceQueue, NamesTheRestOfALocalListAfterATrip) {
  std::ofstream(daemon_.folder() / "drifts.toml") << kDrifts;
  const std::vector<std::string> options{"--local", "--fast", "--accept-travel-risk", "--rig",
                                         source_file("config/rigs/sim.toml")};
  std::vector<std::string> words{"run", "drifts.toml", "a.toml", "b.toml"};
  words.insert(words.end(), options.begin(), options.end());
  const Ended ended = run_eha(words, daemon_.folder());
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::safety_trip)) << ended.err;
  EXPECT_NE(ended.err.find("not played, because the experiment before did not complete: a.toml, b.toml"),
            std::string::npos)
      << ended.err;
  EXPECT_NE(ended.out.find("Next: eha run a.toml b.toml --accept-travel-risk --local --fast --rig "), std::string::npos)
      << ended.out;
  words[2] = "missing.toml";
  const Ended refused = run_eha(words, daemon_.folder());
  EXPECT_NE(refused.err.find("none of the 3 experiments was played"), std::string::npos) << refused.err;
}

TEST_F(ServiceQueue, IsPutInOrderAndEmptiedByHand) {
  const Json taken = Json::parse(eha({"run", "a.toml", "b.toml", "c.toml", "--detach", "--json"}).out);
  const std::int64_t a = taken.at("entries").at(0).at("entry");
  const std::int64_t b = a + 1;
  const std::int64_t c = a + 2;
  ASSERT_EQ(eha({"queue", "move", std::to_string(c), "first"}).code, 0);
  EXPECT_EQ(queued(), (std::vector<std::int64_t>{c, a, b}));
  ASSERT_EQ(eha({"queue", "move", std::to_string(b), "up"}).code, 0);
  EXPECT_EQ(queued(), (std::vector<std::int64_t>{c, b, a}));
  EXPECT_NE(eha({"queue", "move", std::to_string(b), "3"}).out.find("is number 3 of"), std::string::npos);
  EXPECT_EQ(eha({"queue", "move", std::to_string(b), "sideways"}).code, static_cast<int>(ExitCode::usage));
  daemon_.stop(SIGKILL);
  daemon_.start();
  EXPECT_EQ(queued(), (std::vector<std::int64_t>{c, a, b})) << "the order outlives the service";
  const Ended cancelled = eha({"queue", "cancel", std::to_string(a), std::to_string(c)});
  ASSERT_EQ(cancelled.code, 0) << cancelled.err;
  EXPECT_EQ(queued(), (std::vector<std::int64_t>{b}));
  EXPECT_EQ(eha({"queue", "cancel", std::to_string(a)}).code, static_cast<int>(ExitCode::usage));
}

TEST_F(ServiceQueue, HoldsWhatWaitsUntilItIsReleased) {
  Client client(daemon_.socket());
  client.call("arm");
  const std::int64_t on = submit(client, quiet_experiment_text("on", 40.0), false);
  const std::int64_t next = submit(client, quiet_experiment_text("next", 2.0));
  EXPECT_NE(eha({"queue", "hold"}).out.find("is held"), std::string::npos);
  EXPECT_EQ(entry_of(daemon_, next).at("state"), "held");
  EXPECT_EQ(entry_of(daemon_, on).at("state"), "running");
  ASSERT_EQ(eha({"queue", "release", std::to_string(next)}).code, 0);
  EXPECT_EQ(entry_of(daemon_, next).at("state"), "waiting");
  client.call("stop");
  EXPECT_EQ(follow(daemon_, on).at("outcome"), "interrupted");
  EXPECT_EQ(entry_of(daemon_, next).at("state"), "held") << "a stop lets nothing start";
}

TEST_F(ServiceQueue, IsEachUsersOwn) {
  if (!can_change_user()) GTEST_SKIP() << "needs two users";
  daemon_.open_to_all();
  const auto alice = connect_as(kAlice, daemon_);
  const auto bob = connect_as(kBob, daemon_);
  const std::int64_t first = submit(*alice, quiet_experiment_text("first", 2.0));
  const std::int64_t second = submit(*alice, quiet_experiment_text("second", 2.0));
  constexpr int kForbidden = static_cast<int>(ExitCode::permission);
  EXPECT_EQ(refused(*bob, "cancel", {{"entry", first}}).code, kForbidden);
  EXPECT_EQ(refused(*bob, "hold", {{"entry", first}}).code, kForbidden);
  EXPECT_EQ(refused(*bob, "move", {{"entry", second}, {"by", -1}}).code, kForbidden);
  const std::int64_t bobs = submit(*bob, quiet_experiment_text("bobs", 2.0));
  EXPECT_EQ(bob->call("move", {{"entry", bobs}, {"to", 1}}).at("position"), 1) << "of his own";
  EXPECT_EQ(entry_of(daemon_, first).at("position"), 1);
  Client root(daemon_.socket());
  EXPECT_EQ(root.call("move", {{"entry", second}, {"to", 1}}).at("position"), 1);
  EXPECT_EQ(root.call("cancel", {{"entry", first}}).at("state"), "cancelled");
}

TEST_F(ServiceQueue, PlaysSeveralAndAnswersInOneDocument) {
  Client(daemon_.socket()).call("arm");
  const Ended played = eha({"run", "a.toml", "b.toml", "--fast", "--json"});
  const Json document = Json::parse(played.out);
  ASSERT_EQ(document.at("runs").size(), 2U) << played.err;
  for (const Json& run : document.at("runs")) EXPECT_EQ(run.at("outcome"), "completed");
  EXPECT_EQ(document.at("exit_code"), played.code);
}

TEST_F(ServiceQueue, SaysWhatWasHeardLastWhenTheServiceIsGone) {
  Client client(daemon_.socket());
  client.call("arm");
  std::ofstream(daemon_.folder() / "long.toml") << quiet_experiment_text("long", 40.0);
  auto run = std::async(std::launch::async, [&] { return eha({"run", "long.toml"}); });
  while (client.call("status").at("state") != "running") {
  }
  // Clients hear ten times a second.
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  daemon_.stop(SIGKILL);
  const Ended ended = run.get();
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::device_unavailable));
  EXPECT_NE(ended.err.find("heard last, "), std::string::npos) << ended.err;
  EXPECT_NE(ended.err.find("was running, "), std::string::npos) << ended.err;
  EXPECT_NE(ended.err.find("eha status --socket "), std::string::npos) << ended.err;
}

TEST_F(ServiceQueue, RefusesWhatTheRehearsalEndsAtALimitUnlessTold) {
  Client client(daemon_.socket());
  const Refused answer = refused(client, "submit", {{"experiment", kDrifts}, {"name", "drifts.toml"}});
  EXPECT_EQ(answer.code, static_cast<int>(ExitCode::configuration));
  EXPECT_NE(answer.message.find("drifts.toml: 100 % of the rehearsed rods reach a limit"), std::string::npos)
      << answer.message;
  EXPECT_TRUE(queued().empty());
  const Json taken =
      client.call("submit", {{"experiment", kDrifts}, {"name", "drifts.toml"}, {"accept_travel_risk", true}});
  EXPECT_EQ(taken.at("rehearsal").at("chance_of_trip"), 1.0);
  client.call("arm");
  const Json place = client.call("submit", {{"experiment",
                                             "schema = 1\nname = \"goto\"\nduration_s = 60.0\n[place]\n"
                                             "displacement_in = 5.5\n"},
                                            {"name", "goto"}});
  EXPECT_TRUE(place.at("rehearsal").is_null());
}

TEST(ServiceFolders, AreMadeAndLeftToTheirOwner) {
  const TemporaryFolder folder;
  const std::string rig = source_file("config/rigs/sim.toml");
  const std::string ehad =
      std::string(EHAD_PROGRAM) + " --rig " + rig + " --config " + folder.path().string() + "/none";
  const auto start = [&](const std::string& state, const std::string& socket, const std::string& in = "/") {
    return output_of_shell("cd " + in + " && timeout -s TERM 1 " + ehad + " --state " + state + " --socket " + socket +
                           " 2>&1");
  };
  const fs::path own = folder.path() / "made" / "here";
  EXPECT_NE(start(folder.path() / "state", own / "ehad.sock").find("listening at"), std::string::npos);
  EXPECT_TRUE(fs::exists(own));
  const std::string bare = start(folder.path() / "state", "ehad.sock", own);
  EXPECT_NE(bare.find("listening at"), std::string::npos) << bare;
  if (!can_change_user()) GTEST_SKIP() << "needs root, and another user";
  fs::create_directory(folder.path() / "theirs");
  ASSERT_EQ(chown((folder.path() / "theirs").c_str(), kAlice, static_cast<gid_t>(-1)), 0);
  const std::string said = start(folder.path() / "theirs", own / "ehad.sock");
  EXPECT_NE(said.find("belongs to nobody; files of root in this folder would block the service of that user"),
            std::string::npos)
      << said;
  EXPECT_TRUE(fs::is_empty(folder.path() / "theirs"));
  // Who may write there could make the service remove runs of others.
  fs::create_directory(folder.path() / "anybodys");
  fs::permissions(folder.path() / "anybodys", fs::perms::all);
  EXPECT_NE(start(folder.path() / "anybodys", own / "ehad.sock").find("any user may write there"), std::string::npos);
  EXPECT_NE(start(folder.path() / "state", "ehad.sock", folder.path() / "anybodys").find("any user may write there"),
            std::string::npos)
      << "the folder in which it stands is one as well";
}

}  // namespace
}  // namespace eha::test
