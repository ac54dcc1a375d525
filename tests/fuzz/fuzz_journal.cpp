// SPDX-License-Identifier: GPL-3.0-or-later
// The reader of journals is compared with a second reading of the same bytes: it must hand over exactly the blocks with
// a correct CRC and rising indexes, bit for bit, and marks for what lay between. Half of the mutations get correct
// CRCs; otherwise none would pass the first check.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "daemon/record/journal.hpp"
#include "tests/fuzz/memory_file.hpp"
#include "tests/fuzz/require.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t largest);

namespace {

using eha::acquisition::TickRecord;
using eha::fuzz::require;
using eha::record::JournalFacts;
using eha::record::kJournalBlockHeaderSize;
using eha::record::kJournalPreambleSize;
using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t kRecordSize = 64;

/// CRC-32C bit by bit, RFC 3720, appendix B.4; not the library that the journal uses.
std::uint32_t crc32c(Bytes covered, Bytes payload) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const Bytes& bytes : {covered, payload}) {
    for (const std::uint8_t byte : bytes) {
      crc ^= byte;
      for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0x82F63B78U : 0U);
    }
  }
  return ~crc;
}

std::uint32_t u32_at(Bytes file, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i > 0; --i) value = (value << 8U) | file[offset + i - 1];
  return value;
}

bool has_tag(Bytes file, std::size_t offset, std::string_view tag) {
  return file.size() >= offset + tag.size() && std::memcmp(file.data() + offset, tag.data(), tag.size()) == 0;
}

/// A block or the end, as the format is documented.
struct Block {
  bool is_end = false;
  std::size_t size = 0;  ///< with its head
  Bytes covered;
  Bytes payload;
  std::size_t crc_offset = 0;
  std::uint32_t index = 0;
};

/// The block at `offset` if it is complete; its CRC and index are not checked.
bool block_at(Bytes file, std::size_t offset, Block& block) {
  if (file.size() < offset + kJournalBlockHeaderSize) return false;
  block.is_end = has_tag(file, offset, "EHAE");
  if (!block.is_end && !has_tag(file, offset, "EHAB")) return false;
  const std::size_t payload = std::size_t{u32_at(file, offset + 4)} * (block.is_end ? 1 : kRecordSize);
  if (payload > file.size() - offset - kJournalBlockHeaderSize) return false;
  block.size = kJournalBlockHeaderSize + payload;
  block.covered = file.subspan(offset + 4, 8);
  block.payload = file.subspan(offset + kJournalBlockHeaderSize, payload);
  block.crc_offset = offset + 12;
  block.index = u32_at(file, offset + 8);
  return true;
}

/// Offset of the first block; 0 when the file has no complete header.
std::size_t header_end(Bytes file) {
  if (file.size() < kJournalPreambleSize || !has_tag(file, 0, "EHALOG01")) return 0;
  const std::size_t length = u32_at(file, 8);
  return length > file.size() - kJournalPreambleSize ? 0 : kJournalPreambleSize + length;
}

bool header_holds(Bytes file) {
  const std::size_t end = header_end(file);
  return end != 0 &&
         crc32c(file.subspan(8, 4), file.subspan(kJournalPreambleSize, end - kJournalPreambleSize)) == u32_at(file, 12);
}

bool is_intact(Bytes file, const Block& block) {
  return crc32c(block.covered, block.payload) == u32_at(file, block.crc_offset);
}

bool is_object(Bytes text) {
  return nlohmann::ordered_json::parse(text.begin(), text.end(), nullptr, false).is_object();
}

/// What has been compared so far.
struct Compared {
  std::size_t row = 0;
  std::size_t gap = 0;
  std::uint32_t next_index = 0;
  std::uint32_t last_sequence = 0;
};

/// Whether a block whose place is not the next one is taken.
bool may_follow(const Block& block, const Compared& so_far) {
  if (block.index < so_far.next_index) return false;
  if (block.is_end) return true;
  return !block.payload.empty() && (so_far.row == 0 || u32_at(block.payload, 8) > so_far.last_sequence);
}

/// Compares the reader's records and facts with the bytes.
void require_same(Bytes file, const JournalFacts& facts, const std::vector<TickRecord>& records) {
  require(facts.rows == records.size(), "the rows counted are those handed over");
  require(facts.header.is_object() ? header_holds(file) : facts.header.is_null(), "an accepted header has its CRC");
  std::size_t good = facts.header.is_null() ? 0 : header_end(file);
  Compared so_far;
  bool ended = false;
  for (std::size_t offset = good; !ended && offset < file.size();) {
    Block block;
    const bool is_block = block_at(file, offset, block) && is_intact(file, block);
    const bool is_next = is_block && offset == good && block.index == so_far.next_index;
    if (!is_block || (!is_next && !may_follow(block, so_far)) || (block.is_end && !is_object(block.payload))) {
      ++offset;
      continue;
    }
    if (!is_next && (block.index > so_far.next_index || so_far.row > 0)) {
      require(so_far.gap < facts.gaps.size(), "damage between two blocks is a gap");
      const eha::record::JournalGap& gap = facts.gaps[so_far.gap++];
      require(gap.bytes == offset - good && gap.blocks == block.index - so_far.next_index, "a gap has its size");
      require(gap.rows * kRecordSize <= gap.bytes, "no more rows are marked than the damaged bytes held");
      for (std::size_t i = 0; i < gap.rows; ++i) {
        require(records.at(so_far.row + i).flags == eha::acquisition::kLost, "the rows of a gap are marked");
      }
      so_far.row += gap.rows;
    }
    if (block.is_end) {
      ended = true;
    } else if (!block.payload.empty()) {
      const std::size_t count = block.payload.size() / kRecordSize;
      require(so_far.row + count <= records.size(), "every intact block is handed over");
      require(std::memcmp(records.data() + so_far.row, block.payload.data(), block.payload.size()) == 0,
              "records are handed over bit for bit");
      so_far.row += count;
      so_far.last_sequence = u32_at(block.payload, block.payload.size() - kRecordSize + 8);
    }
    so_far.next_index = block.index + 1;
    offset += block.size;
    good = offset;
  }
  require(so_far.row == records.size(), "no record comes from a block that is not intact");
  require(so_far.gap == facts.gaps.size(), "there is no gap without damage");
  require(ended == facts.end.has_value(), "an end is read where there is one");
  require(facts.good_bytes == good && facts.torn_bytes == file.size() - good, "good and torn bytes make the file");
}

void put_u32(std::uint8_t* bytes, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

/// Gives the header and each complete block the correct CRC.
void mend_crcs(std::uint8_t* data, std::size_t size) {
  const Bytes file(data, size);
  std::size_t offset = header_end(file);
  if (offset == 0) return;
  put_u32(data + 12, crc32c(file.subspan(8, 4), file.subspan(kJournalPreambleSize, offset - kJournalPreambleSize)));
  for (Block block; block_at(file, offset, block); offset += block.size) {
    put_u32(data + block.crc_offset, crc32c(block.covered, block.payload));
  }
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t largest,
                                               unsigned seed) {
  const std::size_t mutated = LLVMFuzzerMutate(data, size, largest);
  if (seed % 2 == 0) mend_crcs(data, mutated);
  return mutated;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const eha::fuzz::MemoryFile file(data, size);
  std::vector<TickRecord> records;
  JournalFacts facts;
  try {
    facts = eha::record::read_journal(file.path(), [&](std::span<const TickRecord> some) {
      records.insert(records.end(), some.begin(), some.end());
    });
  } catch (const eha::DataError& error) {
    eha::fuzz::require_good_message(error.what(), file.path().string());
    require(records.empty(), "a journal that is refused has given nothing");
    return 0;
  }
  require_same(Bytes(data, size), facts, records);
  return 0;
}
