// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/journal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <limits>
#include <string_view>
#include <thread>
#include <utility>

#include "core/error.hpp"
#include "core/journal_block.hpp"
#include "core/json_text.hpp"
#include "core/os/writer_lock.hpp"

namespace eha::record {
namespace {

using acquisition::State;
using acquisition::TickRecord;
using journal::append_block;
using journal::append_u32;
using journal::Crc32c;
using journal::kBlockTag;
using journal::kEndTag;
using journal::kLongestEnd;
using journal::kMostRecordsPerBlock;
using journal::u32_at;

constexpr std::string_view kMagic = "EHALOG01";
constexpr mode_t kOwnerAlone = 0600;
constexpr mode_t kReaders = 0644;
constexpr std::uint32_t kLongestHeader = 64u << 20;  // two configuration files are far shorter

/// Bytes that are summed in search of blocks: each of a sound journal once, each of a damaged one hardly more often. In
/// one that was made for it each byte may be part of thousands of blocks with a wrong CRC.
constexpr std::uint64_t kSumsPerByte = 4;
constexpr std::uint64_t kLeastSums = 64u << 20;

/// A part of a journal with a correct CRC.
struct Block {
  bool is_end = false;
  std::uint32_t index = 0;
  std::uint64_t size = 0;  ///< in the file, tag included
};

/// Reads a journal's parts at any offset.
class JournalFile {
 public:
  explicit JournalFile(const std::filesystem::path& path) : path_(path), file_(os::open_regular_file(path)) {
    struct stat status {};
    if (::fstat(file_.get(), &status) != 0) os::throw_system_error("look at", path, errno);
    size_ = static_cast<std::uint64_t>(status.st_size);
    sums_left_ = kSumsPerByte * size_ + kLeastSums;
  }

  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] const std::vector<TickRecord>& records() const { return records_; }  ///< of the last block read

  /// @param end  set to the offset after an intact header   @returns null if the header is damaged
  [[nodiscard]] nlohmann::ordered_json header(std::uint64_t& end) {
    std::array<char, kJournalPreambleSize> preamble;
    if (!read(0, preamble.data(), preamble.size())) return nullptr;
    if (std::string_view(preamble.data(), kMagic.size()) != kMagic) return nullptr;
    const std::uint32_t length = u32_at(preamble.data() + 8);
    if (length > kLongestHeader || length > size_) return nullptr;
    text_.resize(length);
    if (!read(preamble.size(), text_.data(), length)) return nullptr;
    if (Crc32c().add(preamble.data() + 8, 4).add(text_.data(), length).value() != u32_at(preamble.data() + 12)) {
      return nullptr;
    }
    nlohmann::ordered_json header = parse_json_text<nlohmann::ordered_json>(text_);
    if (!header.is_object()) return nullptr;
    end = preamble.size() + length;
    return header;
  }

  /// Whether so much was summed in vain that no further block is looked for.
  [[nodiscard]] bool is_given_up() const { return is_given_up_; }

  /// Returns the block or end that begins at an offset; none unless it is intact.
  [[nodiscard]] std::optional<Block> block_at(std::uint64_t offset) {
    std::array<char, kJournalBlockHeaderSize> head;
    if (!read(offset, head.data(), head.size())) return std::nullopt;
    const std::string_view tag(head.data(), kBlockTag.size());
    const std::uint32_t count = u32_at(head.data() + 4);
    Block block{.is_end = tag == kEndTag, .index = u32_at(head.data() + 8)};
    if (!block.is_end && tag != kBlockTag) return std::nullopt;
    if (count > (block.is_end ? kLongestEnd : kMostRecordsPerBlock)) return std::nullopt;
    const std::uint64_t payload_size = block.is_end ? count : count * std::uint64_t{sizeof(TickRecord)};
    block.size = kJournalBlockHeaderSize + payload_size;
    if (block.size > size_ - offset) return std::nullopt;
    is_given_up_ = payload_size > sums_left_;
    if (is_given_up_) return std::nullopt;
    sums_left_ -= payload_size;
    char* payload = nullptr;
    if (block.is_end) {
      text_.resize(count);
      payload = text_.data();
    } else {
      records_.resize(count);
      payload = reinterpret_cast<char*>(records_.data());
    }
    if (!read(offset + kJournalBlockHeaderSize, payload, payload_size)) return std::nullopt;
    const std::uint32_t crc = Crc32c().add(head.data() + 4, 8).add(payload, payload_size).value();
    if (crc != u32_at(head.data() + 12)) return std::nullopt;
    return block;
  }

  /// Returns the JSON of an end that block_at() has just read; none if it is invalid.
  [[nodiscard]] std::optional<nlohmann::ordered_json> end() const {
    nlohmann::ordered_json end = parse_json_text<nlohmann::ordered_json>(text_);
    if (!end.is_object()) return std::nullopt;
    return end;
  }

  /// Returns the offset of the first tag at or after an offset; the file's size without one.
  [[nodiscard]] std::uint64_t next_tag(std::uint64_t offset) {
    constexpr std::string_view kTagStart = "EHA";
    static_assert(kBlockTag.substr(0, 3) == kTagStart && kEndTag.substr(0, 3) == kTagStart);
    for (;;) {
      if (offset < window_at_ || offset + kBlockTag.size() > window_at_ + window_.size()) {
        window_.resize(kWindow);
        window_at_ = offset;
        window_.resize(os::read_up_to_at(file_, window_.data(), window_.size(), offset, path_));
      }
      const std::string_view rest = std::string_view(window_).substr(offset - window_at_);
      if (rest.size() < kBlockTag.size()) return size_;
      const std::size_t found = rest.find(kTagStart);
      if (found == std::string_view::npos) {
        offset += rest.size() - (kTagStart.size() - 1);
        continue;
      }
      offset += found;
      const std::string_view tag = rest.substr(found, kBlockTag.size());
      if (tag == kBlockTag || tag == kEndTag) return offset;
      if (tag.size() == kBlockTag.size()) ++offset;
    }
  }

 private:
  static constexpr std::size_t kWindow = 1u << 16;

  [[nodiscard]] bool read(std::uint64_t offset, char* bytes, std::size_t size) const {
    return offset < size_ && size <= size_ - offset && os::read_up_to_at(file_, bytes, size, offset, path_) == size;
  }

  const std::filesystem::path& path_;
  os::FileDescriptor file_;
  std::uint64_t size_ = 0;
  std::uint64_t sums_left_ = 0;  ///< bytes
  bool is_given_up_ = false;
  std::vector<TickRecord> records_;
  std::string text_;
  std::string window_;
  std::uint64_t window_at_ = 0;
};

/// Wraps around for invalid tick numbers and periods of a damaged file.
std::int64_t scheduled_ns(std::uint32_t sequence, std::int64_t period_ns) {
  return static_cast<std::int64_t>(std::uint64_t{sequence} * static_cast<std::uint64_t>(period_ns));
}

/// Makes a row of which only the number is known.
TickRecord lost_row(std::uint32_t sequence, std::int64_t scheduled_ns, State state) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  TickRecord row{};
  row.sequence = sequence;
  row.scheduled_ns = scheduled_ns;
  row.state = state;
  row.flags = acquisition::kLost;
  row.requested_V = kUnknown;
  row.applied_V = kUnknown;
  row.displacement_in = kUnknown;
  return row;
}

/// Reads a journal's blocks in order and records its gaps.
class BlockReader {
 public:
  BlockReader(const std::filesystem::path& path, const std::function<void(std::span<const TickRecord>)>& consume)
      : file_(path), consume_(consume) {}

  JournalFacts read() {
    facts_.header = file_.header(facts_.good_bytes);
    std::uint64_t offset = facts_.good_bytes;
    while (offset < file_.size() && !facts_.end && !file_.is_given_up()) {
      const std::optional<Block> block = file_.block_at(offset);
      if (block && take(*block, offset)) {
        offset += block->size;
        facts_.good_bytes = offset;
      } else {
        offset = file_.next_tag(offset + 1);
      }
    }
    facts_.torn_bytes = file_.size() - facts_.good_bytes;
    return std::move(facts_);
  }

  [[nodiscard]] bool found_any() const { return next_index_ > 0; }

 private:
  /// @returns false if the block cannot follow those read
  bool take(const Block& block, std::uint64_t offset) {
    const bool is_next = block.index == next_index_ && offset == facts_.good_bytes;
    if (block.index < next_index_) return false;
    if (block.is_end) {
      facts_.end = file_.end();
      if (!facts_.end) return false;
      if (!is_next) add_gap(block.index, offset, nullptr);
    } else {
      const std::vector<TickRecord>& records = file_.records();
      if (!is_next) {
        // A block of another run, in reused disk space of this journal, has other tick numbers.
        if (records.empty() || (facts_.rows > 0 && records.front().sequence <= last_.sequence)) return false;
        add_gap(block.index, offset, &records.front());
      }
      consume_(records);
      facts_.rows += records.size();
      if (!records.empty()) last_ = records.back();
    }
    next_index_ = block.index + 1;
    return true;
  }

  /// Marks the rows between the last block read and the block at `offset`.
  /// @param after  the first row of that block; none at the end
  void add_gap(std::uint32_t index, std::uint64_t offset, const TickRecord* after) {
    JournalGap gap{.blocks = index - next_index_, .bytes = offset - facts_.good_bytes};
    // With only the header damaged no row is lost.
    if (gap.blocks == 0 && facts_.rows == 0) return;
    const std::uint64_t heads = std::uint64_t{gap.blocks} * kJournalBlockHeaderSize;
    std::uint64_t rows = gap.bytes > heads ? (gap.bytes - heads) / sizeof(TickRecord) : 0;
    const std::uint32_t first = facts_.rows > 0 ? last_.sequence + 1 : 0;
    if (after != nullptr) rows = std::min<std::uint64_t>(rows, after->sequence - first);
    const TickRecord& timed = after != nullptr ? *after : last_;
    const std::int64_t period_ns = timed.sequence > 0 ? timed.scheduled_ns / timed.sequence : 0;
    const State before = facts_.rows > 0 ? last_.state : State::armed;
    const State next = after != nullptr ? after->state : State::ramp_out;
    const State state = before == State::running ? next : before;
    gap.rows = rows;
    gap.at_ns = scheduled_ns(first, period_ns);
    for (std::uint64_t i = 0; i < rows; ++i) {
      const std::uint32_t sequence = first + static_cast<std::uint32_t>(i);
      const TickRecord row = lost_row(sequence, scheduled_ns(sequence, period_ns), state);
      consume_({&row, 1});
    }
    facts_.rows += rows;
    facts_.lost_rows += rows;
    facts_.gaps.push_back(gap);
  }

  JournalFile file_;
  const std::function<void(std::span<const TickRecord>)>& consume_;
  JournalFacts facts_;
  TickRecord last_{};
  std::uint32_t next_index_ = 0;
};

}  // namespace

JournalWriter::JournalWriter(const std::filesystem::path& path, const nlohmann::ordered_json& header,
                             std::size_t records_per_block, GuardPage* page, std::uint64_t expected_rows)
    : path_(path),
      file_(os::open_file(path, O_RDWR | O_CREAT | O_EXCL, kOwnerAlone)),
      page_(page),
      records_per_block_(std::clamp<std::size_t>(records_per_block, 1, kMostRecordsPerBlock)) {
  // Nobody but the owner can open the file yet, so that no reader's lock stands in the way.
  static_cast<void>(os::take_writer_lock(file_, path_));
  open_to_readers_of_folder();
  pending_.reserve(records_per_block_);
  const std::string text = header.dump();
  buffer_.append(kMagic);
  append_u32(buffer_, static_cast<std::uint32_t>(text.size()));
  append_u32(buffer_, Crc32c().add(buffer_.data() + 8, 4).add(text.data(), text.size()).value());
  buffer_.append(text);
  reserve(buffer_.size() + size_of(expected_rows + kReservedRows));
  write_out();
  synchronise();
  begin_in_page();
}

void JournalWriter::open_to_readers_of_folder() const {
  struct stat folder {};
  const std::filesystem::path parent = path_.has_parent_path() ? path_.parent_path() : ".";
  if (::stat(parent.c_str(), &folder) != 0) os::throw_system_error("look at", parent, errno);
  if (::fchmod(file_.get(), (folder.st_mode & kReaders) | kOwnerAlone) != 0)
    os::throw_system_error("change the mode of", path_, errno);
}

JournalWriter::~JournalWriter() {
  give_room_back();
  if (page_ != nullptr) page_->end_journal();
}

void JournalWriter::begin_in_page() {
  if (page_ == nullptr) return;
  struct stat facts {};
  if (::fstat(file_.get(), &facts) != 0) os::throw_system_error("look at", path_, errno);
  // Through a descriptor of this process the path would lead no other one to the file.
  std::error_code unknown;
  const std::filesystem::path real =
      std::filesystem::read_symlink(fmt::format("/proc/self/fd/{}", file_.get()), unknown);
  const std::filesystem::path path = unknown ? std::filesystem::absolute(path_) : real;
  // open() would not accept a path that is too long for the page.
  static_cast<void>(
      page_->begin_journal(path.c_str(), facts.st_dev, facts.st_ino, {.bytes = good_size_, .rows = 0, .index = 0}));
}

std::uint64_t JournalWriter::size_of(std::uint64_t rows) const noexcept {
  return rows * sizeof(TickRecord) + (rows / records_per_block_ + 2) * kJournalBlockHeaderSize + kLongestEnd;
}

void JournalWriter::reserve(std::uint64_t size) {
  if (!can_reserve_ || size <= reserved_) return;
  // The size of the file stays: readers and the guard see the rows only.
  while (::fallocate(file_.get(), FALLOC_FL_KEEP_SIZE, static_cast<off_t>(reserved_),
                     static_cast<off_t>(size - reserved_)) != 0) {
    if (errno == EINTR) continue;
    can_reserve_ = false;
    // Another failure is of the reservation, not of the disk's room; a write says what it means.
    if (errno != ENOSPC && errno != EDQUOT) return;
    os::throw_system_error("reserve room for", path_, errno);
  }
  reserved_ = size;
}

void JournalWriter::keep_room() {
  const std::uint64_t needed = good_size_ + pending_.size() * sizeof(TickRecord);
  if (reserved_ < needed + size_of(kReservedRows / 2)) reserve(needed + size_of(kReservedRows));
}

void JournalWriter::give_room_back() noexcept {
  // It frees what was reserved beyond, and removes a half-written block. Without it only room is lost.
  if (::ftruncate(file_.get(), static_cast<off_t>(good_size_)) == 0) reserved_ = good_size_;
}

void JournalWriter::append(std::span<const acquisition::TickRecord> records) {
  pending_.insert(pending_.end(), records.begin(), records.end());
  write_blocks(records_per_block_);
}

void JournalWriter::write_blocks(std::size_t least_rows) {
  std::size_t written = 0;
  const auto forget_written = [&] {
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(written));
  };
  try {
    while (pending_.size() - written >= least_rows && written < pending_.size()) {
      const std::size_t count = std::min(records_per_block_, pending_.size() - written);
      append_block(buffer_, kBlockTag, static_cast<std::uint32_t>(count), next_index_,
                   {reinterpret_cast<const char*>(pending_.data() + written), count * sizeof(TickRecord)});
      write_out();
      ++next_index_;
      rows_ += count;
      written += count;
      if (page_ != nullptr) page_->set_position({.bytes = good_size_, .rows = rows_, .index = next_index_});
    }
  } catch (...) {
    forget_written();
    throw;
  }
  forget_written();
}

void JournalWriter::write_out() {
  std::size_t done = 0;
  while (done < buffer_.size()) {
    const ssize_t written =
        ::pwrite(file_.get(), buffer_.data() + done, buffer_.size() - done, static_cast<off_t>(good_size_ + done));
    if (written < 0) {
      if (errno == EINTR) continue;
      // A half-written block stays until the next write or the end: cutting it would give the reserved room away.
      const int error_number = errno;
      buffer_.clear();
      os::throw_system_error("write", path_, error_number);
    }
    done += static_cast<std::size_t>(written);
  }
  good_size_ += buffer_.size();
  buffer_.clear();
}

void JournalWriter::synchronise() {
  if (::fdatasync(file_.get()) != 0) os::throw_system_error("write", path_, errno);
}

void JournalWriter::finish(const nlohmann::ordered_json& end) {
  write_blocks(1);
  const std::string text = end.dump();
  append_block(buffer_, kEndTag, static_cast<std::uint32_t>(text.size()), next_index_, text);
  write_out();
  give_room_back();
  synchronise();
  if (page_ != nullptr) page_->end_journal();
}

JournalFacts read_journal(const std::filesystem::path& path,
                          const std::function<void(std::span<const TickRecord>)>& consume) {
  BlockReader reader(path, consume);
  JournalFacts facts = reader.read();
  if (facts.header.is_null() && !reader.found_any()) {
    throw DataError(os::shown(path) + ": not a journal of a run (it does not begin with " + std::string(kMagic) +
                    " and an intact header, and holds no intact block)");
  }
  return facts;
}

bool is_being_written(const std::filesystem::path& path) {
  constexpr std::chrono::seconds kGuardsTime(1);
  const os::FileDescriptor file = os::open_regular_file(path);
  const auto deadline = std::chrono::steady_clock::now() + kGuardsTime;
  while (os::has_writer(file, path)) {
    if (std::chrono::steady_clock::now() > deadline) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

}  // namespace eha::record
