// SPDX-License-Identifier: GPL-3.0-or-later
// Who may do what: the lease between two users, and the queue that belongs to both.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <map>
#include <set>
#include <string>

#include "core/error.hpp"
#include "tests/system/daemon.hpp"

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
  EXPECT_EQ(follow(daemon_, alices).at("outcome"), "completed");
  EXPECT_EQ(entry_of(daemon_, bobs).at("state"), "waiting");
  alice->call("disarm");
  bob->call("arm");
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

TEST_F(ServiceLease, LeavesCancellingToWhoSubmitted) {
  const auto alice = connect_as(kAlice, daemon_);
  const auto bob = connect_as(kBob, daemon_);
  const std::int64_t entry = submit(*alice, experiment_text("alices"));
  EXPECT_EQ(refused(*bob, "cancel", {{"entry", entry}}).code, kRefused);
  EXPECT_EQ(alice->call("cancel", {{"entry", entry}}).at("state"), "cancelled");
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
    EXPECT_EQ(follow(daemon_, entries["bob-faults"]).at("outcome"), "faulted");
  }
  EXPECT_EQ(daemon_.stop(SIGTERM), 0);
  daemon_.start();
  daemon_.open_to_all();
  {
    const auto alice = connect_as(kAlice, daemon_);
    EXPECT_EQ(alice->call("status").at("waiting"), 3);
    alice->call("arm");
    EXPECT_EQ(follow(daemon_, entries["alice-good"]).at("outcome"), "completed");
    follow(daemon_, entries["alice-killed"], [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  }
  EXPECT_EQ(daemon_.stop(SIGKILL), 128 + SIGKILL);
  daemon_.start();
  daemon_.open_to_all();
  const auto bob = connect_as(kBob, daemon_);
  bob->call("arm");
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
