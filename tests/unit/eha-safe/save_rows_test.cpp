// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha-safe/save_rows.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include "core/error.hpp"
#include "daemon/record/journal.hpp"
#include "tests/unit/readers_lock.hpp"
#include "tests/unit/small_disk.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha {
namespace {

using acquisition::TickRecord;

constexpr std::size_t kRowsPerBlock = 100;

/// A journal as a killed process leaves it: its writer has had some rows, its loop has made more.
class SaveRows : public ::testing::Test {
 protected:
  /// @param written  rows that the writer was given   @param made  rows that the loop left in the page
  void leave(std::size_t written, std::size_t made) {
    // A killed process runs no destructor, which would end the journal in its page.
    static auto& killed = *new std::vector<record::JournalWriter*>();  // never destroyed, so that they are no leaks
    killed.push_back(new record::JournalWriter(path_, {{"run", 1}}, kRowsPerBlock, page_.get()));
    record::JournalWriter& writer = *killed.back();
    std::vector<TickRecord> rows(made);
    for (std::size_t k = 0; k < made; ++k) {
      rows[k].sequence = static_cast<std::uint32_t>(k);
      rows[k].applied_V = static_cast<double>(k);
      page_->keep(&rows[k]);
    }
    writer.append({rows.data(), written});
    close(writer.file().get());
  }
  [[nodiscard]] std::uint64_t save() {
    const os::FileDescriptor journal = open_journal(*page_, geteuid());
    return journal ? save_rows(*page_, journal) : 0;
  }
  /// Rows of the journal, each checked to be the next.
  [[nodiscard]] std::uint64_t rows() {
    std::uint32_t next = 0;
    const record::JournalFacts facts = record::read_journal(path_, [&](std::span<const TickRecord> records) {
      for (const TickRecord& row : records) {
        EXPECT_EQ(row.sequence, next);
        EXPECT_EQ(row.applied_V, static_cast<double>(next));
        ++next;
      }
    });
    EXPECT_EQ(facts.torn_bytes, 0U);
    EXPECT_FALSE(facts.end);
    return facts.rows;
  }
  void append_bytes(std::string_view bytes) const {
    std::ofstream(path_, std::ios::binary | std::ios::app)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }

  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "raw.ehalog";
  std::unique_ptr<GuardPage> page_ = std::make_unique<GuardPage>();
};

TEST_F(SaveRows, AppendsWhatTheWriterAndTheQueueHeld) {
  leave(250, 437);
  EXPECT_EQ(save(), 237U) << "two blocks of 100 were written";
  EXPECT_EQ(rows(), 437U);
  EXPECT_EQ(save(), 0U);
  EXPECT_EQ(rows(), 437U);
}

TEST_F(SaveRows, SavesARunOfWhichNothingWasWrittenYet) {
  leave(0, 7);
  EXPECT_EQ(save(), 7U);
  EXPECT_EQ(rows(), 7U);
}

TEST_F(SaveRows, CutsOffAHalfWrittenBlock) {
  leave(200, 260);
  append_bytes("EHAB half a block");
  EXPECT_EQ(save(), 60U);
  EXPECT_EQ(rows(), 260U);
}

TEST_F(SaveRows, UsesTheRoomThatTheProcessHadReservedOnADiskThatIsFull) {
  const test::SmallDisk disk(folder_.path() / "disk");
  if (!disk.mounted()) GTEST_SKIP() << "a small disk can be mounted by root only";
  path_ = folder_.path() / "disk" / "raw.ehalog";
  leave(200, GuardPage::kRows);
  append_bytes("EHAB half a block");
  disk.fill();
  EXPECT_EQ(save(), GuardPage::kRows - 200U);
  EXPECT_EQ(rows(), GuardPage::kRows);
  EXPECT_GT(std::filesystem::space(path_).available, 1'000'000U) << "the rest is given back";
}

TEST_F(SaveRows, SavesNoRowTwiceThatWasWrittenButNotNoted) {
  leave(300, 320);
  // As a process that died between the write of its third block and the note of it.
  const JournalPosition noted = page_->position();
  constexpr std::uint64_t block = record::kJournalBlockHeaderSize + kRowsPerBlock * sizeof(TickRecord);
  page_->set_position({.bytes = noted.bytes - block, .rows = noted.rows - kRowsPerBlock, .index = noted.index - 1});
  EXPECT_EQ(save(), 20U);
  EXPECT_EQ(rows(), 320U);
}

TEST_F(SaveRows, SavesTheNewestRowsWhenThereAreMoreThanThePageHolds) {
  leave(0, GuardPage::kRows + 5);
  EXPECT_EQ(save(), GuardPage::kRows);
}

TEST_F(SaveRows, AddsNothingToAnOrderlyEnd) {
  {
    record::JournalWriter writer(path_, {{"run", 1}}, kRowsPerBlock, page_.get());
    const TickRecord row{};
    page_->keep(&row);
    writer.append({&row, 1});
    writer.finish({{"outcome", "completed"}});
  }
  const auto size = std::filesystem::file_size(path_);
  EXPECT_EQ(save(), 0U);
  EXPECT_EQ(std::filesystem::file_size(path_), size);
}

TEST_F(SaveRows, LeavesTheJournalOfALivingWriterAlone) {
  record::JournalWriter writer(path_, {{"run", 1}}, kRowsPerBlock, page_.get());
  const TickRecord row{};
  page_->keep(&row);
  const auto size = std::filesystem::file_size(path_);
  EXPECT_EQ(save(), 0U);
  EXPECT_EQ(std::filesystem::file_size(path_), size);
}

TEST_F(SaveRows, WaitsForNoLockOfAReader) {
  leave(250, 437);
  const os::FileDescriptor readers = test::locked_by_a_reader(path_);
  EXPECT_EQ(save(), 237U);
  EXPECT_EQ(rows(), 437U);
}

TEST_F(SaveRows, RefusesAnotherFileUnderTheNameOfTheJournal) {
  leave(100, 120);
  std::filesystem::rename(path_, folder_.path() / "moved");
  std::ofstream(path_) << "not a journal";
  EXPECT_THROW(static_cast<void>(save()), IoError);
  EXPECT_EQ(test::content_of(path_), "not a journal");
}

}  // namespace
}  // namespace eha
