// SPDX-License-Identifier: GPL-3.0-or-later
// Minutes: a driver killed again and again, with and without the service.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <memory>
#include <random>
#include <string>

#include "daemon/record/journal.hpp"
#include "daemon/record/run_folder.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/driven_rig.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;

constexpr int kKills = 30;  ///< with the service, and as many without
constexpr std::uint64_t kMostLost = 20;
constexpr unsigned kSeed = 6;

class KilledDriver : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = DrivenRig::obstacle(); !why.empty()) GTEST_SKIP() << why;
  }
  /// Rows that the run of a killed driver lacks.
  [[nodiscard]] std::uint64_t lost(const fs::path& run) {
    const std::uint64_t kept = ticks_recorded(run);
    const std::uint64_t made = rig_.card().commands;
    return made > kept ? made - kept : 0;
  }

  DrivenRig rig_;
  std::mt19937 random_{kSeed};
  std::uniform_int_distribution<std::uint64_t> ticks_{150, 1200};
  std::uint64_t worst_ = 0;
};

TEST_F(KilledDriver, LosesAtMostTwentyRowsWithoutTheService) {
  for (int round = 0; round < kKills; ++round) {
    const TemporaryFolder folder;
    rig_.reset();
    folder.write("rig.toml", DrivenRig::rig_text(std::nullopt));
    folder.write("long.toml", quiet_experiment_text("long", 60.0));
    Driver driver({EHA_PROGRAM, "run", "--local", "--yes", "--rig", "rig.toml", "long.toml"}, rig_.environment(),
                  folder.path());
    ASSERT_TRUE(rig_.is_driven(ticks_(random_)));
    driver.send(SIGKILL);
    ASSERT_EQ(driver.wait(), 128 + SIGKILL) << driver.messages();
    EXPECT_FALSE(rig_.card().is_enabled());
    worst_ = std::max(worst_, lost(only_run(folder.path() / "runs")));
    ASSERT_LE(worst_, kMostLost) << "seed " << kSeed << ", round " << round << ": " << driver.messages();
  }
  std::printf("at most %llu rows lost in %d kills\n", static_cast<unsigned long long>(worst_), kKills);
}

TEST_F(KilledDriver, LosesAtMostTwentyRowsWithTheService) {
  for (int round = 0; round < kKills; ++round) {
    rig_.reset();
    Daemon daemon;
    for (const std::string& variable : rig_.environment()) daemon.set_environment(variable);
    std::ofstream(daemon.rig_file()) << DrivenRig::rig_text(std::nullopt);
    daemon.start();
    {
      Client client(daemon.socket());
      client.call("arm");
      submit(client, quiet_experiment_text("long", 60.0), false);
    }
    ASSERT_TRUE(rig_.is_driven(ticks_(random_)));
    ASSERT_EQ(daemon.stop(SIGKILL), 128 + SIGKILL);
    const std::uint64_t made = rig_.card().commands;
    // Started again at once, as a service manager would, it recovers the run with the rows that the guard saved.
    daemon.start();
    EXPECT_FALSE(rig_.card().is_enabled());
    const fs::path run = only_run(daemon.runs());
    const Json manifest = Json::parse(content_of(run / "run.json"));
    ASSERT_EQ(manifest.at("outcome"), "recovered") << daemon.log();
    ASSERT_GE(manifest.at("recovery").at("rows").get<std::uint64_t>() + kMostLost, made)
        << "seed " << kSeed << ", round " << round << ": " << daemon.log();
    worst_ = std::max(worst_, lost(run));
    ASSERT_LE(worst_, kMostLost);
    daemon.stop(SIGTERM);
  }
  std::printf("at most %llu rows lost in %d kills\n", static_cast<unsigned long long>(worst_), kKills);
}

}  // namespace
}  // namespace eha::test
