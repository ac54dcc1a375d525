// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/journal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <boost/crc.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>

#include "core/error.hpp"
#include "core/guard_page.hpp"
#include "core/os/file_descriptor.hpp"
#include "tests/unit/record/some_ticks.hpp"
#include "tests/unit/small_disk.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::record {
namespace {

using acquisition::TickRecord;

constexpr std::size_t kPerBlock = 10;
constexpr std::size_t kBlockSize = kJournalBlockHeaderSize + kPerBlock * sizeof(TickRecord);

class Journal : public ::testing::Test {
 protected:
  /// 3 full blocks and one of 5 records; without an end unless asked for.
  void write(bool with_end) {
    JournalWriter writer(path_, header_, kPerBlock);
    writer.append(std::span(ticks_).first(7));
    writer.append(std::span(ticks_).subspan(7));
    if (with_end) writer.finish({{"outcome", "completed"}});
    rows_in_blocks_ = writer.rows();
  }

  JournalFacts read(std::vector<TickRecord>& ticks) const {
    ticks.clear();
    return read_journal(path_,
                        [&](std::span<const TickRecord> some) { ticks.insert(ticks.end(), some.begin(), some.end()); });
  }

  [[nodiscard]] std::size_t header_size() const { return kJournalPreambleSize + header_.dump().size(); }
  [[nodiscard]] std::string content() const { return os::read_file(path_); }
  /// Changes one byte in place. Called twice, it changes it back.
  void flip(std::size_t offset, unsigned mask) const {
    std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
    file.seekg(static_cast<std::streamoff>(offset));
    const int byte = file.get();
    file.seekp(static_cast<std::streamoff>(offset));
    file.put(static_cast<char>(static_cast<unsigned>(byte) ^ mask));
  }
  void replace(const std::string& content) const { std::ofstream(path_, std::ios::binary) << content; }

  /// Whether `ticks` are the first ones written, to the bit.
  [[nodiscard]] bool are_first(const std::vector<TickRecord>& ticks) const {
    return same_bits(ticks, {ticks_.begin(), ticks_.begin() + static_cast<std::ptrdiff_t>(ticks.size())});
  }

  /// Whether `ticks` are those written, to the bit, with marks in place of `count` of them.
  [[nodiscard]] bool are_all_but(const std::vector<TickRecord>& ticks, std::size_t first, std::size_t count) const {
    if (ticks.size() != ticks_.size()) return false;
    std::vector<TickRecord> mended = ticks;
    for (std::size_t i = first; i < first + count; ++i) {
      const TickRecord& lost = ticks[i];
      if (lost.flags != acquisition::kLost || lost.sequence != ticks_[i].sequence ||
          lost.scheduled_ns != ticks_[i].scheduled_ns || !std::isnan(lost.applied_V) ||
          !std::isnan(lost.displacement_in)) {
        return false;
      }
      mended[i] = ticks_[i];
    }
    return same_bits(mended, ticks_);
  }

  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "raw.ehalog";
  nlohmann::ordered_json header_ = {{"schema", "eha-journal/1"}, {"name", "test"}};
  std::vector<TickRecord> ticks_ = some_ticks(30);  // 35 with those before and after
  std::uint64_t rows_in_blocks_ = 0;
};

TEST_F(Journal, GivesBackWhatWasWritten) {
  write(true);
  std::vector<TickRecord> ticks;
  const JournalFacts facts = read(ticks);
  EXPECT_TRUE(same_bits(ticks, ticks_));
  EXPECT_EQ(facts.header, header_);
  ASSERT_TRUE(facts.end.has_value());
  EXPECT_EQ((*facts.end)["outcome"], "completed");
  EXPECT_EQ(facts.rows, 35u);
  EXPECT_EQ(facts.torn_bytes, 0u);
}

/// The service holds the folder of a run open and writes by that descriptor, which no other process has.
TEST_F(Journal, IsNamedInThePageByAPathThatOtherProcessesHave) {
  const os::FileDescriptor folder(::open(folder_.path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  ASSERT_TRUE(folder);
  const auto page = std::make_unique<GuardPage>();
  const JournalWriter writer(fmt::format("/proc/self/fd/{}/raw.ehalog", folder.get()), header_, kPerBlock, page.get());
  EXPECT_EQ(std::string(page->journal_path()), path_.string());
}

TEST_F(Journal, IsReadByWhoMayReadItsFolder) {
  // Meanwhile it is locked: who could open it before that could keep its run from beginning.
  using std::filesystem::perms;
  const std::filesystem::path folder = folder_.path() / "run";
  std::filesystem::create_directory(folder);
  const std::vector<std::pair<perms, perms>> cases{
      {perms{0755}, perms{0644}}, {perms{0750}, perms{0640}}, {perms{0700}, perms{0600}}};
  for (const auto& [of_folder, of_file] : cases) {
    std::filesystem::permissions(folder, of_folder);
    const std::filesystem::path path = folder / "journal";
    std::filesystem::remove(path);
    const JournalWriter writer(path, header_, kPerBlock);
    EXPECT_EQ(std::filesystem::status(path).permissions(), of_file);
    EXPECT_TRUE(is_being_written(path));
  }
}

TEST_F(Journal, IsNoPipeThatNobodyWrites) {
  const std::filesystem::path pipe = folder_.path() / "pipe.ehalog";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THROW(static_cast<void>(is_being_written(pipe)), IoError);
}

TEST_F(Journal, ChecksWithTheCrcThatTheStandardNames) {
  // RFC 3720, B.4: 32 bytes of zeros.
  boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true> crc;
  const std::string zeros(32, '\0');
  crc.process_bytes(zeros.data(), zeros.size());
  EXPECT_EQ(crc.checksum(), 0x8A9136AAu);
  // The header's CRC in the file, over its length and its text, as any other program would compute it.
  write(true);
  const std::string file = content();
  std::uint32_t length = 0;
  std::uint32_t stored = 0;
  std::memcpy(&length, file.data() + 8, 4);
  std::memcpy(&stored, file.data() + 12, 4);
  crc.reset();
  crc.process_bytes(file.data() + 8, 4);
  crc.process_bytes(file.data() + kJournalPreambleSize, length);
  EXPECT_EQ(crc.checksum(), stored);
}

TEST_F(Journal, KeepsAllWholeBlocksWhenCutAtAnyByteOfTheLastOne) {
  write(false);
  ASSERT_EQ(rows_in_blocks_, 30u);  // the 5 pending ones were never handed to the system
  const std::size_t whole = std::filesystem::file_size(path_);
  const std::size_t last_block = whole - kBlockSize;
  for (std::size_t size = whole - 1; size >= last_block; --size) {
    std::filesystem::resize_file(path_, size);
    std::vector<TickRecord> ticks;
    const JournalFacts facts = read(ticks);
    ASSERT_EQ(ticks.size(), 20u) << "cut at " << size;
    ASSERT_TRUE(are_first(ticks)) << "cut at " << size;
    ASSERT_EQ(facts.torn_bytes, size - last_block);
    ASSERT_FALSE(facts.end.has_value());
  }
}

TEST_F(Journal, MarksTheRowsOfADamagedBlockAndGivesAllOthersWhateverByteIsFlipped) {
  write(true);
  const std::size_t second_block = header_size() + kBlockSize;
  for (std::size_t i = 0; i < kBlockSize; ++i) {
    for (const unsigned mask : {0x01u, 0x80u, 0xFFu}) {
      flip(second_block + i, mask);
      std::vector<TickRecord> ticks;
      const JournalFacts facts = read(ticks);
      flip(second_block + i, mask);
      ASSERT_TRUE(are_all_but(ticks, kPerBlock, kPerBlock)) << "byte " << i << " of the second block";
      ASSERT_TRUE(facts.end.has_value());
      ASSERT_EQ(facts.rows, ticks_.size());
      ASSERT_EQ(facts.lost_rows, kPerBlock);
      ASSERT_EQ(facts.gaps.size(), 1u);
      ASSERT_EQ(facts.gaps[0].at_ns, 10'000'000);
      ASSERT_EQ(facts.gaps[0].rows, kPerBlock);
      ASSERT_EQ(facts.gaps[0].blocks, 1u);
      ASSERT_EQ(facts.gaps[0].bytes, kBlockSize);
      ASSERT_EQ(facts.torn_bytes, 0u);
    }
  }
}

TEST_F(Journal, CountsLostRowsAsTheExperimentsOnlyBetweenTwoOfIts) {
  write(true);
  std::vector<TickRecord> ticks;
  for (const std::size_t block : {0u, 1u, 2u, 3u}) {
    flip(header_size() + block * kBlockSize, 1);
    const JournalFacts facts = read(ticks);
    flip(header_size() + block * kBlockSize, 1);
    // Three ticks before the experiment are in block 0, two after it in block 3, which has 5 records.
    const std::size_t lost = block == 3 ? 5 : kPerBlock;
    ASSERT_TRUE(are_all_but(ticks, block * kPerBlock, lost)) << "block " << block;
    ASSERT_EQ(facts.lost_rows, lost);
    ASSERT_TRUE(facts.end.has_value());
    const acquisition::State expected = block == 0   ? acquisition::State::armed
                                        : block == 3 ? acquisition::State::ramp_out
                                                     : acquisition::State::running;
    for (std::size_t i = 0; i < lost; ++i) ASSERT_EQ(ticks[block * kPerBlock + i].state, expected);
  }
}

TEST_F(Journal, FindsTheNextBlockAlsoWhenBytesAreMissingOrTooMany) {
  write(true);
  const std::string whole = content();
  const std::size_t second_block = header_size() + kBlockSize;
  std::vector<TickRecord> ticks;
  replace(whole.substr(0, second_block) + whole.substr(second_block + 333));
  EXPECT_EQ(read(ticks).gaps.size(), 1u);
  EXPECT_TRUE(same_bits({ticks.end() - 15, ticks.end()}, {ticks_.end() - 15, ticks_.end()}));
  // 64 KiB is what the search reads at once; a tag lies across the border.
  for (std::size_t size = 65'530; size < 65'545; ++size) {
    replace(whole.substr(0, second_block) + std::string(size, 'E') + whole.substr(second_block));
    const JournalFacts facts = read(ticks);
    ASSERT_TRUE(same_bits(ticks, ticks_)) << size;
    ASSERT_EQ(facts.lost_rows, 0u);
  }
}

TEST_F(Journal, SumsNoByteOfAMadeUpFileThousandsOfTimes) {
  write(true);
  const std::string whole = content();
  const std::size_t second_block = header_size() + kBlockSize;
  // Heads of blocks whose wrong CRC covers all that follows, up to the greatest size of a block.
  constexpr std::size_t kHeads = 8192;
  const auto with_heads = [&](std::size_t count) {
    std::string text = whole.substr(0, second_block);
    for (std::size_t i = 0; i < count; ++i) {
      text += journal::kBlockTag;
      journal::append_u32(text,
                          static_cast<std::uint32_t>((kHeads - i) * kJournalBlockHeaderSize / sizeof(TickRecord)));
      journal::append_u32(text, 1);
      journal::append_u32(text, 0);
    }
    replace(text + std::string((kHeads - count) * kJournalBlockHeaderSize, '\0') + whole.substr(second_block));
  };
  std::vector<TickRecord> ticks;
  with_heads(100);
  EXPECT_TRUE(read(ticks).end.has_value());
  EXPECT_TRUE(same_bits(ticks, ticks_));
  with_heads(kHeads);
  const JournalFacts facts = read(ticks);
  EXPECT_FALSE(facts.end.has_value()) << "the search went on over 500 MB of sums";
  EXPECT_TRUE(same_bits(ticks, {ticks_.begin(), ticks_.begin() + kPerBlock}));
  EXPECT_EQ(facts.torn_bytes, content().size() - second_block);
}

TEST_F(Journal, TakesNoEndOfMoreThan64KiB) {
  {
    JournalWriter writer(path_, header_, kPerBlock);
    writer.append(ticks_);
    writer.finish({{"outcome", std::string(journal::kLongestEnd, 'x')}});
  }
  std::vector<TickRecord> ticks;
  EXPECT_FALSE(read(ticks).end.has_value());
  EXPECT_TRUE(same_bits(ticks, ticks_));
}

TEST_F(Journal, TakesNoBlockOfAnEarlierRunForOneOfItsOwn) {
  write(true);
  const std::string whole = content();
  // The third block's index with ticks that are over: as a disk holds them that lost the file's newest part.
  std::filesystem::remove(path_);
  std::vector<TickRecord> first_ticks(ticks_.begin(), ticks_.begin() + kPerBlock);
  {
    JournalWriter writer(path_, header_, kPerBlock);
    for (int i = 0; i < 3; ++i) writer.append(first_ticks);
  }
  const std::string other = content();
  const std::size_t third_block = header_size() + 2 * kBlockSize;
  replace(whole.substr(0, third_block - 1) + "x" + other.substr(third_block));
  std::vector<TickRecord> ticks;
  read(ticks);
  EXPECT_EQ(ticks.size(), kPerBlock);
  EXPECT_TRUE(are_first(ticks));
}

TEST_F(Journal, GivesEveryRowWhateverByteOfTheHeaderOrEndIsFlipped) {
  write(true);
  std::vector<TickRecord> ticks;
  for (std::size_t i = 0; i < header_size(); ++i) {
    flip(i, 0x10);
    const JournalFacts facts = read(ticks);
    EXPECT_TRUE(facts.header.is_null()) << "byte " << i;
    EXPECT_TRUE(same_bits(ticks, ticks_)) << "byte " << i;
    EXPECT_TRUE(facts.gaps.empty());
    EXPECT_TRUE(facts.end.has_value());
    flip(i, 0x10);
  }
  const std::size_t end = header_size() + 3 * kBlockSize + kJournalBlockHeaderSize + 5 * sizeof(TickRecord);
  for (std::size_t i = end; i < std::filesystem::file_size(path_); ++i) {
    flip(i, 0x10);
    const JournalFacts facts = read(ticks);
    EXPECT_TRUE(same_bits(ticks, ticks_)) << "byte " << i;
    EXPECT_FALSE(facts.end.has_value());
    flip(i, 0x10);
  }
}

TEST_F(Journal, NeverGoesBackToAnEarlierBlock) {
  write(true);
  const std::string whole = content();
  const std::size_t first = header_size();
  replace(whole.substr(0, first) + whole.substr(first + kBlockSize, kBlockSize) + whole.substr(first, kBlockSize));
  std::vector<TickRecord> ticks;
  const JournalFacts facts = read(ticks);
  EXPECT_EQ(facts.lost_rows, 0u) << "no byte before the second block is left to hold them";
  EXPECT_TRUE(same_bits(ticks, {ticks_.begin() + kPerBlock, ticks_.begin() + 2 * kPerBlock}));
}

TEST_F(Journal, RefusesWhatIsNoJournal) {
  std::vector<TickRecord> ticks;
  EXPECT_THROW(read(ticks), IoError);
  for (const std::string& text : {std::string(), std::string("EHALOG01"), std::string(100, '\0'),
                                  std::string("EHALOG01\xff\xff\xff\xff\xff\xff\xff\xff", 16)}) {
    replace(text);
    EXPECT_THROW(read(ticks), DataError) << text.size() << " bytes";
  }
}

TEST_F(Journal, IsLockedWhileItIsWrittenAndNeverOverwritten) {
  {
    const JournalWriter writer(path_, header_, kPerBlock);
    EXPECT_TRUE(is_being_written(path_));
    EXPECT_THROW(JournalWriter(path_, header_, kPerBlock), IoError);
  }
  EXPECT_FALSE(is_being_written(path_));
  EXPECT_THROW(JournalWriter(path_, header_, kPerBlock), IoError);
}

TEST_F(Journal, KeepsItsRoomOnTheDiskAfterABlockThatWasHalfWritten) {
  const auto on_disk = [this] {
    struct stat facts {};
    EXPECT_EQ(::stat(path_.c_str(), &facts), 0);
    return static_cast<std::uint64_t>(facts.st_blocks) * 512;
  };
  constexpr std::uint64_t kReserved = kReservedRows * sizeof(TickRecord);
  {
    JournalWriter writer(path_, header_, kPerBlock);
    if (on_disk() < kReserved) GTEST_SKIP() << "this file system reserves nothing";
    {
      const test::FileSizeLimit limit(header_size() + kBlockSize + kBlockSize / 2);
      EXPECT_THROW(writer.append(ticks_), IoError);
      EXPECT_GE(on_disk(), kReserved) << "for what is written later";
    }
    EXPECT_EQ(writer.rows(), kPerBlock);
    writer.finish({{"outcome", "write_failed"}});
  }
  EXPECT_LT(on_disk(), kReserved / 2) << "given back at the end";
  std::vector<TickRecord> ticks;
  EXPECT_EQ(read(ticks).torn_bytes, 0U);
  EXPECT_TRUE(same_bits(ticks, ticks_));
}

TEST_F(Journal, LeavesNoHalfWrittenBlockBehind) {
  {
    JournalWriter writer(path_, header_, kPerBlock);
    const test::FileSizeLimit limit(header_size() + kBlockSize + kBlockSize / 2);
    EXPECT_THROW(writer.append(ticks_), IoError);
  }
  EXPECT_EQ(std::filesystem::file_size(path_), header_size() + kBlockSize);
}

TEST_F(Journal, GoesOnWhereNoRoomCanBeReservedForAnotherReasonThanAFullDisk) {
  JournalWriter writer(path_, header_, kPerBlock);
  const os::FileDescriptor null = os::open_file("/dev/null", O_RDWR);  // ENODEV
  ASSERT_GE(::dup2(null.get(), writer.file().get()), 0);
  for (std::uint64_t rows = 0; rows < kReservedRows; rows += ticks_.size()) writer.append(ticks_);
  EXPECT_NO_THROW(writer.keep_room());
}

}  // namespace
}  // namespace eha::record
