// SPDX-License-Identifier: GPL-3.0-or-later
// A suspend of the machine: announced, forged and not announced.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "tests/system/daemon.hpp"
#include "tests/system/fake_logind.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;

/// Longest wait for what a suspend brings about on a loaded machine.
constexpr std::chrono::seconds kSeen(5);

std::int64_t start_run_of_minutes(const Daemon& daemon, Client& client) {
  client.call("arm");
  const std::int64_t entry = submit(client, quiet_experiment_text("long", 600.0), false);
  follow(daemon, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  return entry;
}

class ServiceSuspend : public ::testing::Test {
 protected:
  void SetUp() override {
    daemon_.set_environment(std::string("LD_PRELOAD=") + EHA_HOST_TRAP_LIBRARY);
    daemon_.set_environment("EHA_TRAP_SUSPENDED=" + mark().string());
    daemon_.start();
    client_ = std::make_unique<Client>(daemon_.socket());
  }
  [[nodiscard]] fs::path mark() const { return daemon_.folder() / "suspended"; }
  void suspend() const { std::ofstream(mark()) << "100 s"; }

  Daemon daemon_;
  std::unique_ptr<Client> client_;
};

TEST_F(ServiceSuspend, DisarmsARigThatNothingDrives) {
  client_->call("arm");
  suspend();
  EXPECT_TRUE(daemon_.logs("disarmed: the machine was suspended for 100.0 s", kSeen)) << daemon_.log();
  EXPECT_EQ(client_->call("status").at("state"), "idle");
}

TEST_F(ServiceSuspend, MakesARunSafeAtOnce) {
  const std::int64_t entry = start_run_of_minutes(daemon_, *client_);
  suspend();
  ASSERT_TRUE(daemon_.logs("the machine was suspended", kSeen)) << daemon_.log();
  const Json over = follow(daemon_, entry);
  EXPECT_EQ(over.at("outcome"), "faulted");
  EXPECT_NE(over.dump().find("suspended for 100 s"), std::string::npos) << over;
  EXPECT_EQ(client_->call("status").at("state"), "faulted");
}

/// A service with a bus of its own, on which a run of minutes holds the inhibitor.
class ServiceSleep : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!FakeLogind::is_possible()) GTEST_SKIP() << "dbus-daemon is not installed";
    // Another user of the test's group reaches the socket, too.
    fs::permissions(folder_.path(), fs::perms::owner_all | fs::perms::group_exec | fs::perms::others_exec);
    logind_ = std::make_unique<FakeLogind>(folder_.path());
    ASSERT_TRUE(logind_->works());
    daemon_.set_environment("DBUS_SYSTEM_BUS_ADDRESS=" + logind_->address());
    daemon_.start();
    client_ = std::make_unique<Client>(daemon_.socket());
    client_->call("arm");
    entry_ = submit(*client_, quiet_experiment_text("long", 600.0), false);
    ASSERT_TRUE(logind_->await_held(true)) << daemon_.log();
    follow(daemon_, entry_, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  }

  TemporaryFolder folder_;
  std::unique_ptr<FakeLogind> logind_;
  Daemon daemon_;
  std::unique_ptr<Client> client_;
  std::int64_t entry_ = 0;
};

TEST_F(ServiceSleep, IsDelayedWhileARunIsOnAndRampsItOut) {
  EXPECT_EQ(logind_->asked(), "sleep delay");
  logind_->announce_sleep();
  EXPECT_TRUE(logind_->await_held(false)) << daemon_.log();
  const Json over = follow(daemon_, entry_);
  EXPECT_EQ(over.at("outcome"), "interrupted");
  EXPECT_EQ(client_->call("status").at("state"), "idle");
}

TEST_F(ServiceSleep, IsNotAnnouncedByAnotherUser) {
  if (!can_change_user()) GTEST_SKIP() << "takes root";
  ASSERT_TRUE(logind_->forge_sleep(65534));
  // What the same connection is told afterwards comes after it.
  logind_->announce_sleep();
  EXPECT_TRUE(logind_->await_held(false)) << daemon_.log();
  follow(daemon_, entry_);
  const std::string log = daemon_.log();
  const std::size_t told = log.find("the machine is about to be suspended");
  ASSERT_NE(told, std::string::npos) << log;
  EXPECT_EQ(log.find("the machine is about to be suspended", told + 1), std::string::npos) << log;
}

TEST(ServiceWithoutLogind, WarnsThatASuspendCannotBeDelayed) {
  Daemon daemon;
  daemon.set_environment("DBUS_SYSTEM_BUS_ADDRESS=unix:path=/no/such/bus");
  daemon.start();
  Client client(daemon.socket());
  start_run_of_minutes(daemon, client);
  EXPECT_TRUE(daemon.logs("a suspend of the machine cannot be delayed", kSeen)) << daemon.log();
  EXPECT_EQ(client.call("status").at("state"), "running");
}

}  // namespace
}  // namespace eha::test
