// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/batch/record_list.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/error.hpp"
#include "daemon/batch/batch_folder.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::batch {
namespace {

namespace fs = std::filesystem;

TEST(RecordList, SumsNoFileThatHasNoEndOrMoreThanFourGibibytes) {
  const test::TemporaryFolder folder;
  const fs::path sound = folder.write("a.csv", "time_s,u,y\n");
  const fs::path long_file = folder.write("b.csv", "");
  fs::resize_file(long_file, std::uintmax_t{5} << 30U);  // a hole
  const fs::path pipe = folder.path() / "c.csv";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const FoundRecords found = records_of({folder.write("all.list", "a.csv\nb.csv\nc.csv\n").string()});
  ASSERT_EQ(found.records.size(), 1U);
  EXPECT_EQ(found.records[0].source, sound.string());
  ASSERT_EQ(found.skipped.size(), 2U);
  EXPECT_EQ(found.skipped[0].source, long_file.string());
  EXPECT_EQ(found.skipped[0].why, "a file of 5 GiB, more than 4; make a record of a part by eha import");
  EXPECT_EQ(found.skipped[1].source, pipe.string());
  EXPECT_EQ(found.skipped[1].why, "a pipe or a device, which may have no end; save it to a file");
  try {
    static_cast<void>(records_of({pipe.string()}));
    FAIL() << "a batch without a record";
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find(found.skipped[1].why), std::string::npos) << error.what();
  }
}

TEST(RecordList, WaitsForNoPipeInThePlaceOfItsOwnFiles) {
  const test::TemporaryFolder folder;
  const fs::path list = folder.path() / "pipe.list";
  ASSERT_EQ(mkfifo(list.c_str(), 0600), 0);
  EXPECT_THROW(static_cast<void>(records_of({list.string()})), IoError);
  ASSERT_EQ(mkfifo((folder.path() / "batch.json").c_str(), 0600), 0);
  EXPECT_THROW(BatchFolder batch(folder.path()), IoError);
}

}  // namespace
}  // namespace eha::batch
