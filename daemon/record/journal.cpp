// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/crc.hpp>
#include <cerrno>
#include <cstring>
#include <string_view>

#include "core/error.hpp"

namespace eha::record {
namespace {

using acquisition::TickRecord;

constexpr std::string_view kMagic = "EHALOG01";
constexpr std::string_view kBlockTag = "EHAB";
constexpr std::string_view kEndTag = "EHAE";
constexpr std::uint32_t kLongestText = 64u << 20;  // two configuration files are far shorter
constexpr std::uint32_t kMostRecordsPerBlock = 1u << 20;

/// CRC-32C (Castagnoli), as in iSCSI, RFC 3720.
class Crc32c {
 public:
  Crc32c& add(const void* data, std::size_t size) {
    crc_.process_bytes(data, size);
    return *this;
  }
  [[nodiscard]] std::uint32_t value() const { return static_cast<std::uint32_t>(crc_.checksum()); }

 private:
  boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true> crc_;
};

void append_u32(std::string& text, std::uint32_t value) {
  std::array<char, sizeof value> bytes;
  std::memcpy(bytes.data(), &value, sizeof value);
  text.append(bytes.data(), bytes.size());
}

std::uint32_t u32_at(const char* bytes) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

/// Tag, count, index, CRC over count, index and payload, payload.
void append_block(std::string& text, std::string_view tag, std::uint32_t count, std::uint32_t index,
                  std::string_view payload) {
  text.append(tag);
  const std::size_t covered = text.size();
  append_u32(text, count);
  append_u32(text, index);
  append_u32(text, Crc32c().add(text.data() + covered, 8).add(payload.data(), payload.size()).value());
  text.append(payload);
}

nlohmann::ordered_json read_header(const os::FileDescriptor& file, std::uint64_t file_size,
                                   const std::filesystem::path& path) {
  std::array<char, kJournalPreambleSize> preamble;
  if (os::read_up_to(file, preamble.data(), preamble.size(), path) != preamble.size() ||
      std::string_view(preamble.data(), kMagic.size()) != kMagic) {
    throw DataError(path.string() + ": not a journal of a run (it does not begin with " + std::string(kMagic) + ")");
  }
  const std::uint32_t length = u32_at(preamble.data() + 8);
  const std::uint32_t crc = u32_at(preamble.data() + 12);
  const std::string damaged = path.string() + ": the journal's header is damaged; nothing in it can be trusted";
  if (length > kLongestText || length > file_size) throw DataError(damaged);
  std::string text(length, '\0');
  if (os::read_up_to(file, text.data(), length, path) != length) throw DataError(damaged);
  if (Crc32c().add(preamble.data() + 8, 4).add(text.data(), length).value() != crc) throw DataError(damaged);
  nlohmann::ordered_json header = nlohmann::ordered_json::parse(text, nullptr, false);
  if (!header.is_object()) throw DataError(damaged);
  return header;
}

}  // namespace

JournalWriter::JournalWriter(const std::filesystem::path& path, const nlohmann::ordered_json& header,
                             std::size_t records_per_block)
    : path_(path),
      file_(os::open_file(path, O_WRONLY | O_CREAT | O_EXCL)),
      records_per_block_(std::clamp<std::size_t>(records_per_block, 1, kMostRecordsPerBlock)) {
  // Only is_being_written() in another process can hold the lock, and only for a moment.
  while (::flock(file_.get(), LOCK_EX) != 0) {
    if (errno != EINTR) os::throw_system_error("lock", path_, errno);
  }
  pending_.reserve(records_per_block_);
  const std::string text = header.dump();
  buffer_.append(kMagic);
  append_u32(buffer_, static_cast<std::uint32_t>(text.size()));
  append_u32(buffer_, Crc32c().add(buffer_.data() + 8, 4).add(text.data(), text.size()).value());
  buffer_.append(text);
  write_out();
  synchronise();
}

void JournalWriter::append(std::span<const TickRecord> records) {
  while (!records.empty()) {
    const std::size_t taken = std::min(records.size(), records_per_block_ - pending_.size());
    pending_.insert(pending_.end(), records.begin(), records.begin() + static_cast<std::ptrdiff_t>(taken));
    records = records.subspan(taken);
    if (pending_.size() == records_per_block_) write_block();
  }
}

void JournalWriter::write_block() {
  const auto count = static_cast<std::uint32_t>(pending_.size());
  append_block(buffer_, kBlockTag, count, next_index_,
               {reinterpret_cast<const char*>(pending_.data()), pending_.size() * sizeof(TickRecord)});
  write_out();
  ++next_index_;
  rows_ += count;
  pending_.clear();
}

void JournalWriter::write_out() {
  std::string_view rest = buffer_;
  while (!rest.empty()) {
    const ssize_t written = ::write(file_.get(), rest.data(), rest.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      const int error_number = errno;
      // Removes a half-written block, so that the file ends with a good one. Reading works without this.
      if (::ftruncate(file_.get(), static_cast<off_t>(good_size_)) != 0) errno = error_number;
      os::throw_system_error("write", path_, error_number);
    }
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  good_size_ += buffer_.size();
  buffer_.clear();
}

void JournalWriter::synchronise() {
  if (::fdatasync(file_.get()) != 0) os::throw_system_error("write", path_, errno);
}

void JournalWriter::finish(const nlohmann::ordered_json& end) {
  if (!pending_.empty()) write_block();
  const std::string text = end.dump();
  append_block(buffer_, kEndTag, static_cast<std::uint32_t>(text.size()), next_index_, text);
  write_out();
  synchronise();
}

JournalFacts read_journal(const std::filesystem::path& path,
                          const std::function<void(std::span<const TickRecord>)>& consume) {
  const os::FileDescriptor file = os::open_file(path, O_RDONLY);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) os::throw_system_error("look at", path, errno);
  if (S_ISDIR(status.st_mode)) throw IoError("cannot read " + path.string() + ": it is a folder");
  const auto file_size = static_cast<std::uint64_t>(status.st_size);
  JournalFacts facts;
  facts.header = read_header(file, file_size, path);
  facts.good_bytes = static_cast<std::uint64_t>(::lseek(file.get(), 0, SEEK_CUR));

  std::vector<TickRecord> records;
  std::string text;
  for (std::uint32_t index = 0;; ++index) {
    std::array<char, kJournalBlockHeaderSize> head;
    if (os::read_up_to(file, head.data(), head.size(), path) != head.size()) break;
    const std::string_view tag(head.data(), kBlockTag.size());
    const std::uint32_t count = u32_at(head.data() + 4);
    const std::uint32_t crc = u32_at(head.data() + 12);
    const bool is_end = tag == kEndTag;
    if ((!is_end && tag != kBlockTag) || u32_at(head.data() + 8) != index) break;
    if (count > (is_end ? kLongestText : kMostRecordsPerBlock)) break;
    const std::uint64_t size = is_end ? count : count * std::uint64_t{sizeof(TickRecord)};
    if (size > file_size) break;
    char* payload = nullptr;
    if (is_end) {
      text.resize(count);
      payload = text.data();
    } else {
      records.resize(count);
      payload = reinterpret_cast<char*>(records.data());
    }
    if (os::read_up_to(file, payload, size, path) != size) break;
    if (Crc32c().add(head.data() + 4, 8).add(payload, size).value() != crc) break;
    if (is_end) {
      nlohmann::ordered_json end = nlohmann::ordered_json::parse(text, nullptr, false);
      if (!end.is_object()) break;
      facts.end = std::move(end);
      facts.good_bytes += kJournalBlockHeaderSize + size;
      break;
    }
    consume(records);
    facts.rows += count;
    facts.good_bytes += kJournalBlockHeaderSize + size;
  }
  facts.torn_bytes = file_size - std::min(file_size, facts.good_bytes);
  return facts;
}

bool is_being_written(const std::filesystem::path& path) {
  const os::FileDescriptor file = os::open_file(path, O_RDONLY);
  if (::flock(file.get(), LOCK_SH | LOCK_NB) == 0) return false;
  if (errno == EWOULDBLOCK) return true;
  os::throw_system_error("lock", path, errno);
}

}  // namespace eha::record
