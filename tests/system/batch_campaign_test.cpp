// SPDX-License-Identifier: GPL-3.0-or-later
// Two hundred records: a batch that is killed ten times, and one in parts, give the table of one that is left alone.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "tests/system/batch_records.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;

constexpr int kRecords = 200;
constexpr int kKills = 10;
constexpr int kRows = 1500;

class BatchCampaign : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    fs::create_directory(folder_->path() / "records");
    for (int i = 0; i < kRecords; ++i) {
      folder_->write("records/r" + std::to_string(1000 + i) + ".csv",
                     first_order_record(i, i == 77 ? 3.0 : 2.0, kRows));
    }
    whole_ = new Ended(run_eha(batch("whole"), folder_->path()));
  }
  static void TearDownTestSuite() {
    delete whole_;
    delete folder_;
  }

  static std::vector<std::string> batch(const std::string& name, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"batch", "records", "-o", name};
    words.insert(words.end(), more.begin(), more.end());
    for (const char* word : {"--", "--model", "io", "--decimate", "1"}) words.emplace_back(word);
    return words;
  }
  static std::string table(const std::string& name) {
    const fs::path at = folder_->path() / name;
    return content_of(at / "table.csv") + content_of(at / "table.json") + content_of(at / "report.html");
  }
  static std::ptrdiff_t results(const std::string& name) {
    std::error_code none_yet;
    return std::distance(fs::directory_iterator(folder_->path() / name / "records", none_yet),
                         fs::directory_iterator());
  }

  static inline TemporaryFolder* folder_ = nullptr;
  static inline Ended* whole_ = nullptr;
};

TEST_F(BatchCampaign, NamesTheOneRecordThatIsApart) {
  ASSERT_EQ(whole_->code, 0) << whole_->err;
  const auto document = nlohmann::json::parse(content_of(folder_->path() / "whole" / "table.json"));
  EXPECT_EQ(document.at("records_judged"), kRecords);
  EXPECT_TRUE(document.at("trends").empty()) << document.at("trends");
  for (const auto& record : document.at("records")) {
    EXPECT_EQ(record.at("outliers").empty(), record.at("source") != "records/r1077.csv") << record.at("source");
  }
}

TEST_F(BatchCampaign, KilledTenTimesGivesTheSameTable) {
  std::mt19937 random(1);
  for (int kill = 0; kill < kKills; ++kill) {
    const std::ptrdiff_t before = results("killed");
    // Somewhere within the next records, not only between two.
    const std::ptrdiff_t until = before + 1 + static_cast<std::ptrdiff_t>(random() % 18);
    const Ended killed = interrupt_eha(
        batch("killed"), folder_->path(), [&] { return results("killed") >= until; }, SIGKILL);
    ASSERT_EQ(killed.code, 128 + SIGKILL);
    ASSERT_LT(results("killed"), kRecords) << "killed too late to prove anything";
  }
  const Ended resumed = run_eha(batch("killed"), folder_->path());
  ASSERT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_EQ(table("killed"), table("whole"));
}

TEST_F(BatchCampaign, InPartsGivesTheSameTable) {
  for (const std::string part : {"1", "2", "3"}) {
    const Ended ended = run_eha(batch("part" + part, {"--shard", part + "/3"}), folder_->path());
    ASSERT_EQ(ended.code, 0) << ended.err;
  }
  const Ended merged = run_eha({"batch", "merge", "part1", "part2", "part3", "-o", "merged"}, folder_->path());
  ASSERT_EQ(merged.code, 0) << merged.err;
  EXPECT_EQ(table("merged"), table("whole"));
}

}  // namespace
}  // namespace eha::test
