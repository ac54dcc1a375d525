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

TEST(ServiceSleep, IsDelayedWhileARunIsOnAndRampsItOut) {
  if (!FakeLogind::is_possible()) GTEST_SKIP() << "dbus-daemon is not installed";
  const TemporaryFolder folder;
  FakeLogind logind(folder.path());
  ASSERT_TRUE(logind.works());
  Daemon daemon;
  daemon.set_environment("DBUS_SYSTEM_BUS_ADDRESS=" + logind.address());
  daemon.start();
  Client client(daemon.socket());
  client.call("arm");
  const std::int64_t entry = submit(client, quiet_experiment_text("long", 600.0), false);
  ASSERT_TRUE(logind.await_held(true)) << daemon.log();
  EXPECT_EQ(logind.asked(), "sleep delay");
  follow(daemon, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  logind.announce_sleep();
  EXPECT_TRUE(logind.await_held(false)) << daemon.log();
  const Json over = follow(daemon, entry);
  EXPECT_EQ(over.at("outcome"), "interrupted");
  EXPECT_EQ(client.call("status").at("state"), "idle");
}

TEST(ServiceSleep, ThatCannotBeDelayedIsWarnedOf) {
  Daemon daemon;
  daemon.set_environment("DBUS_SYSTEM_BUS_ADDRESS=unix:path=/no/such/bus");
  daemon.start();
  Client client(daemon.socket());
  start_run_of_minutes(daemon, client);
  EXPECT_TRUE(daemon.logs("a suspend of the machine cannot be delayed", kSeen)) << daemon.log();
  EXPECT_EQ(client.call("status").at("state"), "running");
}

TEST(ServiceSleep, IsNotAnnouncedByAnotherUser) {
  if (!FakeLogind::is_possible() || !can_change_user()) GTEST_SKIP() << "takes dbus-daemon and root";
  const TemporaryFolder folder;
  fs::permissions(folder.path(), fs::perms::owner_all | fs::perms::group_exec | fs::perms::others_exec);
  FakeLogind logind(folder.path());
  ASSERT_TRUE(logind.works());
  Daemon daemon;
  daemon.set_environment("DBUS_SYSTEM_BUS_ADDRESS=" + logind.address());
  daemon.start();
  Client client(daemon.socket());
  client.call("arm");
  const std::int64_t entry = submit(client, quiet_experiment_text("long", 600.0), false);
  ASSERT_TRUE(logind.await_held(true)) << daemon.log();
  follow(daemon, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  ASSERT_TRUE(logind.forge_sleep(65534));
  // What the same connection is told afterwards comes after it.
  logind.announce_sleep();
  EXPECT_TRUE(logind.await_held(false)) << daemon.log();
  follow(daemon, entry);
  const std::string log = daemon.log();
  const std::size_t told = log.find("the machine is about to be suspended");
  ASSERT_NE(told, std::string::npos) << log;
  EXPECT_EQ(log.find("the machine is about to be suspended", told + 1), std::string::npos) << log;
}

}  // namespace
}  // namespace eha::test
