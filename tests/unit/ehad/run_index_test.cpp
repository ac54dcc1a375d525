// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/run_index.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "core/error.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kSize = 10'000;
constexpr uid_t kOwner = 1000;
constexpr const char* kAccepted = R"({"accepted":true,"models":[]})";
constexpr const char* kRejected = R"({"accepted":false,"models":[]})";

class RunIndexTest : public ::testing::Test {
 protected:
  RunIndexTest() { fs::create_directories(runs()); }
  [[nodiscard]] fs::path runs() const { return folder_.path() / "runs"; }
  [[nodiscard]] fs::path file() const { return folder_.path() / "runs.index"; }
  [[nodiscard]] RunIndex open() const { return {file(), runs()}; }
  [[nodiscard]] bool has(const std::string& name) const { return fs::exists(runs() / name); }

  /// A run folder of about kSize bytes.
  void make(const std::string& name, const std::string& outcome, const std::string& identification) const {
    fs::create_directories(runs() / name);
    std::ofstream(runs() / name / "run.json")
        << R"({"schema":"eha-run/1","outcome":")" << outcome << R"(","identification":)" << identification << "}";
    std::ofstream(runs() / name / "raw.h5") << std::string(kSize, 'x');
  }
  /// The same, played by the service.
  void play(RunIndex& index, const std::string& name, const std::string& outcome = "completed",
            const std::string& identification = kRejected) const {
    make(name, outcome, identification);
    index.begin(name, kOwner);
    index.update(name);
  }
  /// As many later runs as are never removed, so that those before them are old.
  void play_newest(RunIndex& index) const {
    for (std::size_t i = 0; i < RunIndex::kNewestKept; ++i) play(index, fmt::format("newest-{}", i));
  }

  test::TemporaryFolder folder_;
};

TEST_F(RunIndexTest, LeavesEverythingWithinTheBudget) {
  RunIndex index = open();
  play(index, "a");
  const Retention retention = index.keep_within(2 * kSize, {});
  EXPECT_TRUE(retention.removed.empty());
  EXPECT_EQ(retention.refusal, "");
  EXPECT_GT(retention.bytes, kSize);
}

TEST_F(RunIndexTest, RemovesTheOldestBySequenceHoweverTheyAreNamed) {
  RunIndex index = open();
  play(index, "20380101T000000Z-first");
  play(index, "19700101T000000Z-second");
  play_newest(index);
  const Retention retention = index.keep_within(index.bytes() - 1, {});
  ASSERT_EQ(retention.removed.size(), 1U);
  EXPECT_EQ(retention.removed[0].name, "20380101T000000Z-first");
  EXPECT_FALSE(has("20380101T000000Z-first"));
  EXPECT_TRUE(has("19700101T000000Z-second"));
}

TEST_F(RunIndexTest, NeverRemovesTheNewestAcceptedIncidentsRunsInProgressAndThoseInUse) {
  RunIndex index = open();
  play(index, "accepted", "completed", kAccepted);
  play(index, "used");
  for (const char* incident : {"faulted", "interrupted", "deadline", "write_failed", "recovered"}) {
    play(index, incident, incident, "null");
  }
  play(index, "on", "in_progress", "null");
  play_newest(index);
  const Retention retention = index.keep_within(1, {"used"});
  EXPECT_TRUE(retention.removed.empty());
  EXPECT_NE(retention.refusal.find("1 accepted runs"), std::string::npos) << retention.refusal;
  EXPECT_NE(retention.refusal.find("5 incidents"), std::string::npos) << retention.refusal;
  EXPECT_NE(retention.refusal.find("eha runs remove"), std::string::npos) << retention.refusal;
}

TEST_F(RunIndexTest, LetsAnAcknowledgedIncidentGo) {
  {
    RunIndex index = open();
    play(index, "faulted", "faulted", "null");
    index.acknowledge("faulted");
    EXPECT_THROW(index.acknowledge("none"), UsageError);
    play(index, "completed");
    EXPECT_THROW(index.acknowledge("completed"), UsageError);
    play_newest(index);
  }
  RunIndex index = open();
  EXPECT_TRUE(index.runs().at("faulted").acknowledged);
  EXPECT_EQ(index.keep_within(index.bytes() - 1, {}).removed.at(0).name, "faulted");
}

TEST_F(RunIndexTest, LetsLatestNameTheNewestRunThatIsLeftWithAnAcceptedModel) {
  RunIndex index = open();
  const auto latest = [&] { return fs::is_symlink(runs() / "latest") ? fs::read_symlink(runs() / "latest") : ""; };
  play(index, "b-first", "completed", kAccepted);
  play(index, "a-second", "completed", kAccepted);
  play(index, "c-rejected");
  play(index, "d-newest", "completed", kAccepted);
  fs::create_symlink("d-newest", runs() / "latest");
  index.remove("c-rejected", kOwner);
  EXPECT_EQ(latest(), "d-newest");
  index.remove("d-newest", kOwner);
  EXPECT_EQ(latest(), "a-second") << "by the order of the runs, not by their names";
  fs::remove_all(runs() / "a-second");  // without the service
  index.update("a-second");
  EXPECT_EQ(latest(), "b-first");
  index.remove("b-first", kOwner);
  EXPECT_EQ(latest(), "") << "no link that leads to nothing";
}

TEST_F(RunIndexTest, KnowsTheSequenceAcrossRestartsAndAfterRemovals) {
  {
    RunIndex index = open();
    play(index, "b");
    play(index, "a");
    index.remove("b", kOwner);
  }
  RunIndex index = open();
  EXPECT_FALSE(index.runs().contains("b"));
  play(index, "0");
  EXPECT_LT(index.runs().at("a").sequence, index.runs().at("0").sequence);
}

TEST_F(RunIndexTest, ReadsRunsThatItDoesNotKnowAndForgetsThoseThatHaveGone) {
  make("1", "completed", kRejected);
  make("2", "completed", kAccepted);
  {
    const RunIndex index = open();
    EXPECT_LT(index.runs().at("1").sequence, index.runs().at("2").sequence);
    EXPECT_TRUE(index.runs().at("2").accepted);
  }
  fs::remove_all(runs() / "1");
  EXPECT_EQ(open().runs().size(), 1U);
}

TEST_F(RunIndexTest, SurvivesALineThatWasCutOff) {
  {
    RunIndex index = open();
    play(index, "a", "faulted", "null");
  }
  std::ofstream(file(), std::ios::app) << R"({"run":"a","sequence":7,"own)";
  const RunIndex index = open();
  EXPECT_EQ(index.runs().at("a").outcome, "faulted");
  EXPECT_EQ(index.runs().at("a").sequence, 1);
}

TEST_F(RunIndexTest, NoticesBeforeItRemovesARunThatSomebodyAcceptedMeanwhile) {
  RunIndex index = open();
  play(index, "a");
  play_newest(index);
  make("a", "completed", kAccepted);
  EXPECT_TRUE(index.keep_within(index.bytes() - 1, {}).removed.empty());
  EXPECT_TRUE(has("a"));
}

TEST_F(RunIndexTest, NoticesRoomThatWasMadeByHand) {
  RunIndex index = open();
  play(index, "a", "completed", kAccepted);
  play(index, "b", "completed", kAccepted);
  fs::remove_all(runs() / "a");
  EXPECT_EQ(index.keep_within(2 * kSize, {}).refusal, "");
}

TEST_F(RunIndexTest, LeavesWhatItCannotRead) {
  fs::create_directories(runs() / "a");
  std::ofstream(runs() / "a" / "run.json") << "no manifest";
  RunIndex index = open();
  play_newest(index);
  EXPECT_TRUE(index.keep_within(1, {}).removed.empty());
  EXPECT_TRUE(has("a"));
}

TEST_F(RunIndexTest, NamesTheOwnerOfARunThatAnotherWouldRemove) {
  RunIndex index = open();
  index.begin("of-root", 0);
  try {
    index.remove("of-root", kOwner);
    FAIL() << "removed";
  } catch (const PermissionError& error) {
    EXPECT_STREQ(error.what(), "of-root: of root; only its owner and root may remove it");
  }
}

TEST_F(RunIndexTest, LetsOnlyOwnerAndRootRemoveARun) {
  RunIndex index = open();
  play(index, "a");
  play(index, "b");
  play(index, "on", "in_progress", "null");
  EXPECT_THROW(index.remove("a", kOwner + 1), PermissionError);
  EXPECT_GT(index.remove("a", kOwner), kSize);
  EXPECT_GT(index.remove("b", 0), kSize);
  EXPECT_THROW(index.remove("on", kOwner), UsageError);
  EXPECT_THROW(index.remove("..", 0), UsageError);
  EXPECT_FALSE(has("a") || has("b"));
}

}  // namespace
}  // namespace eha::service
