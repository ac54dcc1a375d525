// SPDX-License-Identifier: GPL-3.0-or-later
// What becomes of a record whose process ends otherwise than by itself; a script stands for `eha fit`.
#include "daemon/batch/run_records.hpp"

#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::batch {
namespace {

class RunRecords : public ::testing::Test {
 protected:
  /// A program that is called as `eha fit SOURCE ...`.
  std::filesystem::path program(const std::string& body) {
    const std::filesystem::path path = folder_.write("fit.sh", "#!/bin/sh\n" + body + "\n");
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    return path;
  }
  bool run(const std::filesystem::path& program) {
    return run_records(batch_, {.program = program,
                                .jobs = 2,
                                .shard = {},
                                .progress = [this](double, const std::string& text) { shown_ += text + "\n"; },
                                .stopped = [] { return false; }});
  }

  std::string shown_;
  test::TemporaryFolder folder_;
  Record first_{.id = "0001-a", .source = "a.csv", .sha256 = ""};
  Record second_{.id = "0002-b", .source = "b.csv", .sha256 = ""};
  BatchFolder batch_{folder_.path() / "out", {rules_of({}), {first_, second_}}};
};

TEST_F(RunRecords, LeavesOpenWhatWasToldToEndAndGoesOnWithIt) {
  for (const char* signal : {"TERM", "INT", "KILL"}) {
    EXPECT_FALSE(run(program(std::string("[ $2 = a.csv ] && kill -") + signal + " $$\necho '{\"models\": []}'")))
        << signal;
    EXPECT_FALSE(batch_.result(first_)) << signal;
  }
  ASSERT_TRUE(batch_.result(second_));
  EXPECT_TRUE(is_judged(*batch_.result(second_)));
  EXPECT_TRUE(run(program("echo '{\"models\": []}'")));
  EXPECT_TRUE(batch_.result(first_));
}

TEST_F(RunRecords, NamesTheRecordAtWorkWithItsTime) {
  const std::string mark = (folder_.path() / "b.done").string();
  EXPECT_TRUE(run(program("if [ $2 = a.csv ]; then until [ -e '" + mark + "' ]; do sleep 0.05; done; else touch '" +
                          mark + "'; fi\necho '{\"models\": []}'")));
  EXPECT_NE(shown_.find("record 1 of 2: a.csv, 0 s"), std::string::npos) << shown_;
}

TEST_F(RunRecords, TakesTheResultOfEveryRecordOfManyShortOnes) {
  std::vector<Record> records;
  for (int i = 1; i <= 9; ++i) {
    const std::string name = "r" + std::to_string(i);
    records.push_back({.id = "000" + std::to_string(i) + "-" + name, .source = name + ".csv", .sha256 = ""});
  }
  BatchFolder many(folder_.path() / "many", {rules_of({}), records});
  EXPECT_TRUE(run_records(many, {.program = program("echo '{\"models\": [], \"of\": \"'$2'\"}'"),
                                 .jobs = 4,
                                 .shard = {},
                                 .progress = [](double, const std::string&) {},
                                 .stopped = [] { return false; }}));
  for (const Record& record : records) {
    ASSERT_TRUE(many.result(record)) << record.id;
    EXPECT_EQ(many.result(record)->fit.value("of", ""), record.source);
  }
}

TEST_F(RunRecords, StopsAtAFullDiskWithItsMessageAndLeavesTheRecordOpen) {
  for (const char* words :
       {"No space left on device", "Disk quota exceeded", "File too large", "Read-only file system"}) {
    try {
      run(program("[ $2 = b.csv ] && sleep 60\necho 'eha: error: cannot write models/io.json: " + std::string(words) +
                  "' >&2\nexit 74"));
      ADD_FAILURE() << words;
    } catch (const IoError& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find("a.csv"), std::string::npos) << what;
      EXPECT_NE(what.find(std::string("cannot write models/io.json: ") + words), std::string::npos) << what;
      EXPECT_EQ(what.find("eha: error"), std::string::npos) << what;
      EXPECT_NE(what.find("the same command goes on"), std::string::npos) << what;
    }
    EXPECT_FALSE(batch_.result(first_)) << words;
    EXPECT_FALSE(batch_.result(second_)) << "killed with the batch";
  }
  EXPECT_TRUE(run(program("echo '{\"models\": []}'")));
  EXPECT_TRUE(is_judged(*batch_.result(first_)));
}

TEST_F(RunRecords, ListsARecordThatCannotBeReadAndGoesOn) {
  EXPECT_TRUE(
      run(program("[ $2 = b.csv ] && echo '{\"models\": []}' && exit 0\n"
                  "echo 'eha: error: cannot read a.csv: Input/output error' >&2\nexit 74")));
  ASSERT_TRUE(batch_.result(first_));
  EXPECT_EQ(batch_.result(first_)->exit_code, 74);
  EXPECT_TRUE(is_judged(*batch_.result(second_)));
}

TEST_F(RunRecords, KeepsACrashAsAResultThatIsNotTriedAgain) {
  EXPECT_TRUE(run(program("kill -SEGV $$")));
  const std::optional<Result> crashed = batch_.result(first_);
  ASSERT_TRUE(crashed);
  EXPECT_FALSE(is_judged(*crashed));
  EXPECT_EQ(crashed->exit_code, 128 + SIGSEGV);
  EXPECT_TRUE(batch_.open_records({}).empty());
}

}  // namespace
}  // namespace eha::batch
