// SPDX-License-Identifier: GPL-3.0-or-later
// Permissions: the lease between two users, and their common queue.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <map>
#include <set>
#include <string>

#include "core/error.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;

constexpr uid_t kAlice = 65534;  // nobody
constexpr uid_t kBob = 1;        // daemon
constexpr int kRefused = static_cast<int>(ExitCode::permission);

class ServiceLease : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!can_change_user()) GTEST_SKIP() << "needs root, to act as two users";
    daemon_.start();
    daemon_.open_to_all();
  }

  Daemon daemon_;
};

TEST_F(ServiceLease, IsRefusedToAnotherUserWhileItIsHeld) {
  const auto alice = connect_as(kAlice, daemon_);
  const auto bob = connect_as(kBob, daemon_);
  alice->call("arm");
  const Refused answer = refused(*bob, "arm");
  EXPECT_EQ(answer.code, kRefused);
  EXPECT_NE(answer.message.find("nobody"), std::string::npos) << answer.message;
  EXPECT_EQ(refused(*bob, "disarm").code, kRefused);
  EXPECT_EQ(alice->call("status").at("lease").at("uid"), kAlice);
  alice->call("disarm");
  EXPECT_EQ(bob->call("arm").at("state"), "armed");
  EXPECT_TRUE(daemon_.logs("armed by daemon (uid 1"));
}

TEST_F(ServiceLease, LetsOnlyItsHoldersExperimentsStart) {
  const auto alice = connect_as(kAlice, daemon_);
  const auto bob = connect_as(kBob, daemon_);
  const std::int64_t bobs = submit(*bob, experiment_text("bobs"));
  const std::int64_t alices = submit(*alice, experiment_text("alices"));
  alice->call("arm");
  EXPECT_EQ(alice->call("release").at("released"), Json::array({alices}));
  EXPECT_EQ(refused(*bob, "release").code, kRefused);
  EXPECT_EQ(refused(*alice, "release", {{"entry", bobs}}).code, kRefused);
  EXPECT_EQ(follow(daemon_, alices).at("outcome"), "completed");
  EXPECT_EQ(entry_of(daemon_, bobs).at("state"), "held");
  alice->call("disarm");
  bob->call("arm");
  bob->call("release", {{"entry", bobs}});
  EXPECT_EQ(follow(daemon_, bobs).at("outcome"), "completed");
}

TEST_F(ServiceLease, DoesNotKeepAnotherUserFromStopping) {
  const auto alice = connect_as(kAlice, daemon_);
  const auto bob = connect_as(kBob, daemon_);
  alice->call("arm");
  const std::int64_t entry = submit(*alice, quiet_experiment_text("long", 600.0), false);
  follow(daemon_, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  EXPECT_EQ(bob->call("stop").at("stopped"), "ramping_out");
  EXPECT_EQ(follow(daemon_, entry).at("outcome"), "interrupted");
  EXPECT_TRUE(daemon_.logs("stop by daemon (uid 1, pid"));
}

TEST_F(ServiceLease, DoesNotKeepAnotherUserFromStoppingBetweenRuns) {
  const auto alice = connect_as(kAlice, daemon_);
  const auto bob = connect_as(kBob, daemon_);
  alice->call("arm");
  EXPECT_EQ(bob->call("stop").at("stopped"), "disarmed");
  EXPECT_EQ(alice->call("status").at("state"), "idle");
}

TEST_F(ServiceLease, StaysWithItsHolderThroughAFaultUntilItsReleaseOrRoot) {
  const auto alice = connect_as(kAlice, daemon_);
  const auto bob = connect_as(kBob, daemon_);
  const auto root = connect_as(0, daemon_);
  alice->call("arm");
  EXPECT_EQ(follow(daemon_, submit(*alice, faulting_experiment_text("faults"))).at("outcome"), "faulted");
  const Refused answer = refused(*bob, "arm");
  EXPECT_EQ(answer.code, kRefused);
  EXPECT_NE(answer.message.find("nobody"), std::string::npos) << answer.message;
  EXPECT_EQ(refused(*bob, "disarm").code, kRefused);
  alice->call("disarm");
  EXPECT_EQ(bob->call("arm").at("state"), "armed");
  EXPECT_EQ(root->call("arm", {{"take_from", kBob}}).at("state"), "armed");
  EXPECT_TRUE(daemon_.logs("the lease of daemon is taken over by root")) << daemon_.log();
}

TEST_F(ServiceLease, IsTakenOverByRootOnlyWhereRootNamesItsHolder) {
  const auto alice = connect_as(kAlice, daemon_);
  const auto root = connect_as(0, daemon_);
  alice->call("arm");
  const std::int64_t entry = submit(*alice, quiet_experiment_text("long", 600.0), false);
  follow(daemon_, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  for (const Json& params : {Json::object(), Json{{"take_from", kBob}}}) {
    const Refused answer = refused(*root, "arm", params);
    EXPECT_EQ(answer.code, kRefused);
    for (const char* said : {"the lease is nobody's", "since ", "\"long\" of nobody is being played"}) {
      EXPECT_NE(answer.message.find(said), std::string::npos) << answer.message;
    }
  }
  const Ended asked = run_eha({"arm", "--socket", daemon_.socket()}, daemon_.folder());
  EXPECT_EQ(asked.code, static_cast<int>(ExitCode::usage));
  EXPECT_NE(asked.err.find("\"long\" of nobody is being played"), std::string::npos) << asked.err;
  EXPECT_EQ(alice->call("status").at("lease").at("uid"), kAlice);
  const Ended taken = run_eha({"arm", "--yes", "--socket", daemon_.socket()}, daemon_.folder());
  EXPECT_EQ(taken.code, 0) << taken.err;
  EXPECT_EQ(alice->call("status").at("lease").at("uid"), 0);
  EXPECT_EQ(alice->call("stop").at("stopped"), "ramping_out") << "a stop is free";
}

TEST_F(ServiceLease, KeepsAnotherUserFromReloadingAlsoWhileDisarmed) {
  const auto alice = connect_as(kAlice, daemon_);
  const auto bob = connect_as(kBob, daemon_);
  bob->call("reload");
  alice->call("arm");
  EXPECT_NE(refused(*bob, "reload").message.find("nobody"), std::string::npos);
  EXPECT_NE(refused(*connect_as(0, daemon_), "reload").message.find("the rig is armed"), std::string::npos);
  bob->call("stop");
  EXPECT_EQ(alice->call("status").at("state"), "idle");
  const Refused answer = refused(*bob, "reload");
  EXPECT_EQ(answer.code, kRefused);
  EXPECT_NE(answer.message.find("not reloaded"), std::string::npos) << answer.message;
  EXPECT_NE(answer.message.find("nobody"), std::string::npos) << answer.message;
  alice->call("reload");
  connect_as(0, daemon_)->call("reload");
  alice->call("disarm");
  bob->call("reload");
}

TEST_F(ServiceLease, StaysWithItsHolderThroughAStop) {
  const auto alice = connect_as(kAlice, daemon_);
  const auto bob = connect_as(kBob, daemon_);
  alice->call("arm");
  const std::int64_t entry = submit(*alice, quiet_experiment_text("long", 600.0), false);
  follow(daemon_, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  bob->call("stop");
  follow(daemon_, entry);
  EXPECT_EQ(refused(*bob, "arm").code, kRefused);
  EXPECT_EQ(alice->call("arm").at("state"), "armed");
}

TEST_F(ServiceLease, LeavesCancellingToTheOwnerAndRoot) {
  const auto alice = connect_as(kAlice, daemon_);
  const auto bob = connect_as(kBob, daemon_);
  const std::int64_t entry = submit(*alice, experiment_text("alices"));
  EXPECT_EQ(refused(*bob, "cancel", {{"entry", entry}}).code, kRefused);
  EXPECT_EQ(alice->call("cancel", {{"entry", entry}}).at("state"), "cancelled");
  const std::int64_t other = submit(*alice, experiment_text("alices"));
  EXPECT_EQ(connect_as(0, daemon_)->call("cancel", {{"entry", other}}).at("state"), "cancelled");
}

TEST_F(ServiceLease, GivesEachUserAPartOfTheQueueOnly) {
  const auto alice = connect_as(kAlice, daemon_);
  const auto bob = connect_as(kBob, daemon_);
  for (int i = 0; i < 20; ++i) submit(*alice, experiment_text("alices"));
  const Refused answer =
      refused(*alice, "submit", {{"experiment", experiment_text("one-more")}, {"name", "e.toml"}, {"fast", true}});
  EXPECT_EQ(answer.code, static_cast<int>(ExitCode::io));
  EXPECT_NE(answer.message.find("20 experiments of nobody"), std::string::npos) << answer.message;
  submit(*bob, experiment_text("bobs"));
}

/// Five experiments of two users: one is cancelled, one trips a limit, the service is restarted in between, once in an
/// orderly way and once by SIGKILL while one is on.
TEST_F(ServiceLease, AccountsForEveryExperimentOfTwoUsersAcrossRestarts) {
  std::map<std::string, std::int64_t> entries;
  {
    const auto alice = connect_as(kAlice, daemon_);
    const auto bob = connect_as(kBob, daemon_);
    entries["alice-good"] = submit(*alice, experiment_text("alice-good"));
    entries["bob-faults"] = submit(*bob, faulting_experiment_text("bob-faults"));
    entries["alice-cancelled"] = submit(*alice, experiment_text("alice-cancelled"));
    entries["bob-good"] = submit(*bob, experiment_text("bob-good"));
    entries["alice-killed"] = submit(*alice, quiet_experiment_text("alice-killed", 600.0), false);
    alice->call("cancel", {{"entry", entries["alice-cancelled"]}});
    bob->call("arm");
    bob->call("release", {{"entry", entries["bob-faults"]}});
    EXPECT_EQ(follow(daemon_, entries["bob-faults"]).at("outcome"), "faulted");
  }
  EXPECT_EQ(daemon_.stop(SIGTERM), 0);
  daemon_.start();
  daemon_.open_to_all();
  {
    const auto alice = connect_as(kAlice, daemon_);
    EXPECT_EQ(alice->call("status").at("held"), 3);
    alice->call("arm");
    alice->call("release");
    EXPECT_EQ(follow(daemon_, entries["alice-good"]).at("outcome"), "completed");
    follow(daemon_, entries["alice-killed"], [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  }
  EXPECT_EQ(daemon_.stop(SIGKILL), 128 + SIGKILL);
  daemon_.start();
  daemon_.open_to_all();
  const auto bob = connect_as(kBob, daemon_);
  bob->call("arm");
  bob->call("release");
  EXPECT_EQ(follow(daemon_, entries["bob-good"]).at("outcome"), "completed");

  std::map<std::string, std::string> account;
  const Json queue = bob->call("queue");
  for (const Json& entry : queue.at("entries")) {
    const std::string state = entry.at("state");
    account[entry.at("name")] = state == "over" ? entry.at("outcome").get<std::string>() : state;
  }
  const std::map<std::string, std::string> expected{{"alice-good", "completed"},
                                                    {"bob-faults", "faulted"},
                                                    {"alice-cancelled", "cancelled"},
                                                    {"bob-good", "completed"},
                                                    {"alice-killed", "recovered"}};
  EXPECT_EQ(account, expected);
  // Each that began has one run, and only those.
  std::multiset<std::string> played;
  for (const auto& run : fs::directory_iterator(daemon_.runs())) {
    if (run.is_directory() && !run.is_symlink()) played.insert(run.path().filename().string().substr(17));
  }
  EXPECT_EQ(played, (std::multiset<std::string>{"alice-good", "bob-faults", "bob-good", "alice-killed"}));
}

}  // namespace
}  // namespace eha::test
