// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/retention.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/unit/temporary_folder.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kSize = 10'000;

class RetentionTest : public ::testing::Test {
 protected:
  /// A run folder of about kSize bytes.
  void make(const std::string& name, const std::string& outcome, const std::string& identification) const {
    const fs::path folder = folder_.path() / name;
    fs::create_directories(folder);
    std::ofstream(folder / "run.json") << R"({"schema":"eha-run/1","outcome":")" << outcome << "\"" << identification
                                       << "}";
    std::ofstream(folder / "raw.h5") << std::string(kSize, 'x');
  }
  [[nodiscard]] bool has(const std::string& name) const { return fs::exists(folder_.path() / name); }

  test::TemporaryFolder folder_;
};

constexpr const char* kAccepted = R"(,"identification":{"accepted":true,"models":[]})";
constexpr const char* kRejected = R"(,"identification":{"accepted":false,"models":[]})";

TEST_F(RetentionTest, LeavesEverythingWithinTheBudget) {
  make("1", "completed", kRejected);
  make("2", "faulted", "");
  const Retention retention = keep_within_budget(folder_.path(), 3 * kSize, {});
  EXPECT_TRUE(retention.removed.empty());
  EXPECT_FALSE(retention.over_budget);
  EXPECT_GT(retention.bytes, 2 * kSize);
}

TEST_F(RetentionTest, RemovesTheOldestThatMayGoUntilTheRestIsWithinTheBudget) {
  make("1", "completed", kAccepted);
  make("2", "completed", kRejected);
  make("3", "faulted", R"(,"identification":null)");
  make("4", "completed", kRejected);
  const Retention retention = keep_within_budget(folder_.path(), kSize * 5 / 2, {});
  ASSERT_EQ(retention.removed.size(), 2U);
  EXPECT_EQ(retention.removed[0].name, "2");
  EXPECT_EQ(retention.removed[1].name, "3");
  EXPECT_TRUE(has("1") && has("4") && !has("2") && !has("3"));
  EXPECT_FALSE(retention.over_budget);
}

TEST_F(RetentionTest, NeverRemovesAcceptedRunsThoseInProgressAndThoseInUse) {
  make("1", "completed", kAccepted);
  make("2", "in_progress", "");
  make("3", "completed", "");
  const Retention retention = keep_within_budget(folder_.path(), 1, {"3"});
  EXPECT_TRUE(retention.removed.empty());
  EXPECT_TRUE(retention.over_budget);
  EXPECT_TRUE(has("1") && has("2") && has("3"));
}

TEST_F(RetentionTest, LeavesWhatItCannotRead) {
  fs::create_directories(folder_.path() / "1");
  std::ofstream(folder_.path() / "1" / "run.json") << "no manifest";
  make("2", "completed", kRejected);
  const Retention retention = keep_within_budget(folder_.path(), 1, {});
  EXPECT_TRUE(has("1"));
  EXPECT_FALSE(has("2"));
}

}  // namespace
}  // namespace eha::service
