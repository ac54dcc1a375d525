// SPDX-License-Identifier: GPL-3.0-or-later
// A rig past whose piston oil leaks: the answer of eha tune, and the trial that trips.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

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

/// A printed text without its breaks of lines.
std::string on_one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
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
  EXPECT_NE(on_one_line(tuned.out).find("oil leaks past the piston: without the leak the same trial passes"),
            std::string::npos)
      << tuned.out;
  EXPECT_EQ(tuned.out.find("Next: eha track"), std::string::npos) << tuned.out;
  EXPECT_EQ(tuned.out.find("Next: eha characterise"), std::string::npos) << "the repair comes first\n" << tuned.out;
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

TEST(LeakyAxis, HasOneFindingAndNoWayRoundInACircleOnceItsSheetShowsTheLeak) {
  const TemporaryFolder folder;
  const std::string rig = source_file("config/rigs/sim-leaky.toml");
  const std::string finding = "il leaks past the piston or through the valve";
  const std::string remedy = "repair the leak first";
  const auto play = [&](std::vector<std::string> words, bool drives) {
    if (drives) words.insert(words.end(), {"--local", "--fast", "--rig", rig});
    const Ended ended = run_eha(words, folder.path());
    const std::string text = ended.out + ended.err;
    EXPECT_NE(text.find(finding), std::string::npos) << text;
    std::string unwrapped = text;
    std::replace(unwrapped.begin(), unwrapped.end(), '\n', ' ');
    EXPECT_NE(unwrapped.find(remedy), std::string::npos) << text;
    EXPECT_EQ(text.find("Next: eha characterise"), std::string::npos) << text;
    EXPECT_EQ(text.find("Next: eha tune"), std::string::npos) << text;
    EXPECT_EQ(text.find("friction bends the edges"), std::string::npos) << "another diagnosis\n" << text;
    return text;
  };
  play({"characterise"}, true);
  play({"run", source_file("config/experiments/paper.toml")}, true);
  play({"fit", "runs/latest"}, false);
  const std::string tuned = play({"tune", "runs/latest", "--rig", rig, "-o", "leaky.toml"}, false);
  EXPECT_EQ(tuned.find("Next: eha track"), std::string::npos) << tuned;
  const std::string tracked = play({"track", "leaky.toml"}, true);
  EXPECT_EQ(tracked.find("likely, in this order"), std::string::npos) << tracked;
  const std::string page = read_page(folder.path() / "runs");
  EXPECT_NE(page.find(finding), std::string::npos);
  EXPECT_NE(page.find("Next: repair the leak first"), std::string::npos);
  EXPECT_EQ(page.find("likely, in this order"), std::string::npos) << "the rod followed: nothing is off or unplugged";
  EXPECT_NE(content_of(folder.path() / "runs" / "latest" / "report.html").find(finding), std::string::npos);
}

TEST(LeakyAxis, IsNotMovedInATrialThatWouldTripAndIsCommissionedAnewAfterTheRepair) {
  const TemporaryFolder folder;
  std::filesystem::copy_file(source_file("config/rigs/sim-leaky.toml"), folder.path() / "rig.toml");
  const Ended ended = run_eha({"commission", "rig.toml", "--yes", "--fast"}, folder.path());
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::model_rejected)) << ended.err;
  EXPECT_NE(ended.err.find("the trial is left out, nothing moved: it would trip on this rig (not_following)"),
            std::string::npos)
      << ended.err;
  EXPECT_NE(ended.err.find("the rig leaks: "), std::string::npos) << ended.err;
  EXPECT_EQ(ended.err.find("to go on with this step"), std::string::npos) << ended.err;
  EXPECT_NE(ended.out.find("Next: eha commission rig.toml -o commission-2 --fast --yes"), std::string::npos)
      << ended.out;
  EXPECT_TRUE(read_page(folder.path() / "runs").empty()) << "it was played";
}

}  // namespace
}  // namespace eha::test
