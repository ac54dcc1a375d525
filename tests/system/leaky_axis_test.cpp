// SPDX-License-Identifier: GPL-3.0-or-later
// A rig past whose piston oil leaks: the answer of eha tune, and the trial that trips.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "core/error.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

std::string read_page(const std::filesystem::path& runs) {
  for (const auto& entry : std::filesystem::directory_iterator(runs)) {
    if (entry.path().filename().string().find("-track-") != std::string::npos) {
      return content_of(entry.path() / "report.html");
    }
  }
  return {};
}

TEST(LeakyAxis, IsToldBeforeItsTrialTripsAndTheTripNamesTheLeak) {
  const TemporaryFolder folder;
  const std::string rig = source_file("config/rigs/sim-leaky.toml");
  const std::string paper = source_file("config/experiments/paper.toml");
  const Ended run = run_eha({"run", paper, "--local", "--fast", "--rig", rig, "-o", "runs"}, folder.path());
  ASSERT_EQ(run.code, 0) << run.err;
  const Ended tuned = run_eha({"tune", "runs/latest", "--rig", rig, "-o", "leaky.toml"}, folder.path());
  ASSERT_EQ(tuned.code, 0) << tuned.err;
  EXPECT_NE(tuned.out.find("will trip on this rig: no_motion after some 4 s"), std::string::npos) << tuned.out;
  EXPECT_NE(tuned.out.find("oil leaks past the piston: without the leak the same trial passes"), std::string::npos)
      << tuned.out;
  EXPECT_EQ(tuned.out.find("Next: eha track"), std::string::npos) << tuned.out;
  EXPECT_NE(tuned.out.find("Next: eha characterise"), std::string::npos) << tuned.out;
  EXPECT_NE(content_of(folder.path() / "leaky.html").find("its trial will trip on this rig</h2>"), std::string::npos);
  const Ended tracked =
      run_eha({"track", "leaky.toml", "--local", "--fast", "--rig", rig, "-o", "runs"}, folder.path());
  EXPECT_EQ(tracked.code, static_cast<int>(ExitCode::safety_trip)) << tracked.err;
  EXPECT_NE(tracked.err.find("no_motion at 4."), std::string::npos) << tracked.err;
  EXPECT_NE(tracked.err.find("so that valve, sensor and hydraulics work"), std::string::npos) << tracked.err;
  EXPECT_NE(tracked.out.find("Next: eha characterise"), std::string::npos) << tracked.out;
  EXPECT_NE(read_page(folder.path() / "runs").find("oil leaks past the piston and the volts make up for it"),
            std::string::npos);
}

}  // namespace
}  // namespace eha::test
