// SPDX-License-Identifier: GPL-3.0-or-later
// What becomes of the rows when the disk takes no more of them.
#include "daemon/play/journal_thread.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>

#include "core/error.hpp"
#include "tests/unit/record/some_ticks.hpp"
#include "tests/unit/small_disk.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::play {
namespace {

using acquisition::RecordQueue;
using acquisition::TickRecord;

class JournalOnAFullDisk : public ::testing::Test {
 protected:
  void begin(const std::filesystem::path& folder,
             acquisition::TimeBase time_base = acquisition::TimeBase::virtual_time) {
    path_ = folder / "raw.ehalog";
    journal_ = std::make_unique<record::JournalWriter>(path_, nlohmann::ordered_json{{"run", 1}}, 100);
    folder_watch_ = std::make_unique<record::FolderWatch>(folder);
    thread_ = std::make_unique<JournalThread>(queue_, *journal_, *folder_watch_, time_base, watch_);
  }
  /// A loop's next rows, as fast as the queue takes them, which ends early where `stops_on_failure`.
  void make(std::size_t rows, bool stops_on_failure) {
    for (std::size_t made = 0; made < rows && !(stops_on_failure && queue_.writer_failed());) {
      TickRecord row{};
      row.sequence = static_cast<std::uint32_t>(made_);
      if (!queue_.push(row)) {
        std::this_thread::yield();
        continue;
      }
      ++made;
      ++made_;
    }
  }
  void await_failure() {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!queue_.writer_failed() && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
    ASSERT_TRUE(queue_.writer_failed());
  }
  /// Ends the journal. @returns the rows that it has, each checked to be the next
  [[nodiscard]] std::uint64_t rows() {
    if (thread_->journal_is_sound()) journal_->finish({{"outcome", "write_failed"}});
    thread_.reset();
    journal_.reset();
    std::uint32_t next = 0;
    return record::read_journal(path_,
                                [&](std::span<const TickRecord> records) {
                                  for (const TickRecord& row : records) EXPECT_EQ(row.sequence, next++);
                                })
        .rows;
  }

  test::TemporaryFolder folder_;
  std::filesystem::path path_;
  RecordQueue queue_;
  RunWatch watch_;
  std::unique_ptr<record::JournalWriter> journal_;
  std::unique_ptr<record::FolderWatch> folder_watch_;
  std::unique_ptr<JournalThread> thread_;
  std::size_t made_ = 0;
};

/// A kill takes the rows that wait for their block.
TEST(Journal, HasTheFirstFaultInItsFileBeforeItsBlockIsFull) {
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "raw.ehalog";
  record::JournalWriter journal(path, nlohmann::ordered_json{{"run", 1}}, 100);
  const record::FolderWatch folder_watch(folder.path());
  RecordQueue queue;
  RunWatch watch;
  JournalThread thread(queue, journal, folder_watch, acquisition::TimeBase::monotonic, watch);
  TickRecord row{};
  for (row.sequence = 0; row.sequence < 7; ++row.sequence) {
    if (row.sequence == 6) row.fault = acquisition::Fault::sensor_slip;
    ASSERT_TRUE(queue.push(row));
  }
  const auto last_fault = [&] {
    auto fault = acquisition::Fault::none;
    record::read_journal(path, [&](std::span<const TickRecord> rows) { fault = rows.back().fault; });
    return fault;
  };
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (last_fault() == acquisition::Fault::none && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::yield();
  }
  EXPECT_EQ(last_fault(), acquisition::Fault::sensor_slip);
  EXPECT_EQ(thread.finish(), "");
}

TEST_F(JournalOnAFullDisk, EndsARunThatIsLongerThanExpectedWhileItsLastRowsHaveRoom) {
  const test::SmallDisk disk(folder_.path() / "disk");
  if (!disk.mounted()) GTEST_SKIP() << "a small disk can be mounted by root only";
  begin(folder_.path() / "disk");
  disk.fill();
  make(4 * record::kReservedRows, true);
  ASSERT_TRUE(queue_.writer_failed());
  EXPECT_GE(made_, record::kReservedRows / 2 - RecordQueue::kCapacity);
  make(record::kReservedRows / 2 - 2 * RecordQueue::kCapacity, false);  // a ramp-out of 16 s at 1 kHz
  const std::string message = thread_->finish();
  EXPECT_NE(message.find("No space left"), std::string::npos) << message;
  EXPECT_NE(message.find("every row is kept"), std::string::npos) << message;
  EXPECT_TRUE(thread_->journal_is_sound());
  EXPECT_EQ(rows(), made_);
}

TEST_F(JournalOnAFullDisk, GivesBackTheRoomThatItDidNotUse) {
  const test::SmallDisk disk(folder_.path() / "disk");
  if (!disk.mounted()) GTEST_SKIP() << "a small disk can be mounted by root only";
  const auto free = [&] { return std::filesystem::space(folder_.path() / "disk").available; };
  const auto before = free();
  begin(folder_.path() / "disk");
  EXPECT_LE(free() + record::kReservedRows * sizeof(TickRecord), before);
  make(1000, false);
  EXPECT_EQ(thread_->finish(), "");
  EXPECT_EQ(rows(), made_);
  EXPECT_LT(before - free(), 100'000U);
}

TEST_F(JournalOnAFullDisk, TriesAgainToWriteWhatItCouldNot) {
  begin(folder_.path());
  {
    const test::FileSizeLimit limit(100'000);
    make(3000, true);
    await_failure();
  }
  make(500, false);
  const std::string message = thread_->finish();
  EXPECT_NE(message.find("File too large"), std::string::npos) << message;
  EXPECT_NE(message.find("every row is kept"), std::string::npos) << message;
  EXPECT_EQ(rows(), made_);
}

TEST_F(JournalOnAFullDisk, CountsTheRowsThatAreLost) {
  begin(folder_.path());
  const test::FileSizeLimit limit(100'000);
  make(3000, true);
  await_failure();
  make(500, false);
  const std::string message = thread_->finish();
  EXPECT_FALSE(thread_->journal_is_sound());
  const std::uint64_t kept = rows();
  EXPECT_GT(kept, 1000U);
  EXPECT_NE(message.find(std::to_string(kept) + " rows before are kept"), std::string::npos) << message;
  EXPECT_NE(message.find(std::to_string(made_ - kept) + " later ones are lost"), std::string::npos) << message;
}

TEST_F(JournalOnAFullDisk, CountsTheRowsOfAnUnfinishedBlockAsLostWhereTheDiskCannotBeSynchronised) {
  begin(folder_.path(), acquisition::TimeBase::monotonic);
  // It takes every write, and cannot be synchronised.
  const os::FileDescriptor null = os::open_file("/dev/null", O_RDWR);
  ASSERT_GE(dup2(null.get(), journal_->file().get()), 0);
  make(150, false);
  await_failure();
  const std::string message = thread_->finish();
  EXPECT_FALSE(thread_->journal_is_sound());
  EXPECT_NE(message.find("the 100 rows before are kept"), std::string::npos) << message;
  EXPECT_NE(message.find("50 later ones are lost"), std::string::npos) << message;
}

}  // namespace
}  // namespace eha::play
