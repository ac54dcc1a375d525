// SPDX-License-Identifier: GPL-3.0-or-later
// Minutes: a driver killed again and again, with and without the service.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
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

TEST_F(KilledDriver, LeavesTheRodWhereItWasInTheClosedLoopOfATrial) {
  constexpr int kTrials = 40;
  constexpr std::int64_t kMostToOff_ns = 200'000'000;
  const TemporaryFolder folder;
  folder.write("rig.toml", DrivenRig::rig_text(std::nullopt));
  fs::copy_file(source_file("tests/vm/rod.json"), folder.path() / "rod.json");
  const Ended tuned =
      run_eha({"tune", "rod.json", "--rig", "rig.toml", "--kind", "p", "-o", "axis.toml"}, folder.path());
  ASSERT_EQ(tuned.code, 0) << tuned.err;
  // From the first moments of the step into the trapezoids.
  std::uniform_int_distribution<std::uint64_t> moments(2500, 10'000);
  double furthest_in = 0.0;
  std::int64_t longest_ns = 0;
  for (int round = 0; round < kTrials; ++round) {
    rig_.reset();
    rig_.card().dead_band_V = 0.25;
    fs::remove_all(folder.path() / "runs");
    Driver driver({EHA_PROGRAM, "track", "axis.toml", "--local", "--yes", "--rig", "rig.toml"}, rig_.environment(),
                  folder.path());
    const std::uint64_t moment = moments(random_);
    ASSERT_TRUE(rig_.is_driven(moment)) << "round " << round;
    const double fastest_in_per_s = CardMemory::kGain_in_per_V_s * std::abs(-5.0 + rig_.card().output_code / 6553.5);
    const std::int64_t killed_ns = std::chrono::steady_clock::now().time_since_epoch().count();
    driver.send(SIGKILL);
    ASSERT_EQ(driver.wait(), 128 + SIGKILL) << driver.messages();
    ASSERT_FALSE(rig_.card().is_enabled()) << "round " << round;
    const std::int64_t off_ns = rig_.card().disabled_ns - killed_ns;
    const double moved_in = 1e-9 * static_cast<double>(off_ns) * fastest_in_per_s;
    EXPECT_LT(off_ns, kMostToOff_ns) << "seed " << kSeed << ", round " << round << ", tick " << moment;
    EXPECT_LE(moved_in, 0.5) << "seed " << kSeed << ", round " << round << ", tick " << moment;
    longest_ns = std::max(longest_ns, off_ns);
    furthest_in = std::max(furthest_in, moved_in);
  }
  std::printf("%d trials killed: off within %.0f ms, the rod moved at most %.3f in\n", kTrials,
              1e-6 * static_cast<double>(longest_ns), furthest_in);
}

}  // namespace
}  // namespace eha::test
