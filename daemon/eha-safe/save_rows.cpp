// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha-safe/save_rows.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "core/error.hpp"
#include "core/journal_block.hpp"
#include "core/os/files.hpp"
#include "core/os/writer_lock.hpp"

namespace eha {
namespace {

constexpr std::uint64_t kRowsPerBlock = 100;
/// A recovery holds the lock for a moment; the writer holds it during its whole life.
constexpr std::chrono::seconds kLockPatience{2};

/// @returns false if another process keeps the lock
bool take_lock(const os::FileDescriptor& file, const std::string& path) {
  const auto deadline = std::chrono::steady_clock::now() + kLockPatience;
  while (!os::take_writer_lock(file, path)) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

/// The journal of a dead process, at the end of its last whole block.
class Journal {
 public:
  Journal(const GuardPage& page, const os::FileDescriptor& file)
      : path_(page.journal_path()), file_(file), end_(page.position()) {
    while (take_block()) {
    }
  }

  [[nodiscard]] const JournalPosition& end() const { return end_; }
  /// Whether the process itself completed the journal: nothing may be appended.
  [[nodiscard]] bool is_ended() const { return is_ended_; }

  /// Also gives back the room that the process had reserved beyond.
  void cut_off() const {
    if (ftruncate(file_.get(), static_cast<off_t>(end_.bytes)) != 0) os::throw_system_error("write", path_, errno);
  }

  void append(const std::string& rows) {
    std::string block;
    const std::uint64_t count = rows.size() / GuardPage::kRowSize;
    journal::append_block(block, journal::kBlockTag, static_cast<std::uint32_t>(count), end_.index, rows);
    for (std::size_t done = 0; done < block.size();) {
      const ssize_t written =
          pwrite(file_.get(), block.data() + done, block.size() - done, static_cast<off_t>(end_.bytes + done));
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) {
        const int error_number = errno;
        cut_off();
        os::throw_system_error("write", path_, error_number);
      }
      done += static_cast<std::size_t>(written);
    }
    end_ = {end_.bytes + block.size(), end_.rows + count, end_.index + 1};
  }

  void synchronise() const {
    if (fdatasync(file_.get()) != 0) os::throw_system_error("write", path_, errno);
  }

 private:
  bool read(std::uint64_t offset, char* bytes, std::size_t size) const {
    return pread(file_.get(), bytes, size, static_cast<off_t>(offset)) == static_cast<ssize_t>(size);
  }

  /// Skips one block that the process wrote without noting it before its death. @returns false if no whole block
  /// follows
  bool take_block() {
    std::array<char, journal::kBlockHeaderSize> head{};
    if (!read(end_.bytes, head.data(), head.size())) return false;
    const std::string_view tag(head.data(), journal::kBlockTag.size());
    const std::uint64_t count = journal::u32_at(head.data() + 4);
    if (journal::u32_at(head.data() + 8) != end_.index || count > journal::kMostRecordsPerBlock) return false;
    if (tag != journal::kBlockTag && tag != journal::kEndTag) return false;
    if (tag == journal::kEndTag && count > journal::kLongestEnd) return false;
    std::string payload(tag == journal::kEndTag ? count : count * GuardPage::kRowSize, '\0');
    if (!read(end_.bytes + head.size(), payload.data(), payload.size())) return false;
    const std::uint32_t crc = journal::Crc32c().add(head.data() + 4, 8).add(payload.data(), payload.size()).value();
    if (crc != journal::u32_at(head.data() + 12)) return false;
    is_ended_ = tag == journal::kEndTag;
    if (is_ended_) return false;
    end_ = {end_.bytes + head.size() + payload.size(), end_.rows + count, end_.index + 1};
    return true;
  }

  std::string path_;
  const os::FileDescriptor& file_;
  JournalPosition end_;
  bool is_ended_ = false;
};

}  // namespace

os::FileDescriptor open_journal(const GuardPage& page, uid_t owner) {
  if (!page.has_journal()) return {};
  const std::string path = page.journal_path();
  os::FileDescriptor file = os::open_file(path, O_RDWR | O_NOFOLLOW | O_NONBLOCK);
  struct stat facts {};
  if (fstat(file.get(), &facts) != 0) os::throw_system_error("look at", path, errno);
  // Root must not write to another user's file because a user's page names it.
  const bool is_owners = facts.st_uid == owner || geteuid() == owner;
  if (!S_ISREG(facts.st_mode) || facts.st_dev != page.journal_device() || facts.st_ino != page.journal_inode() ||
      !is_owners) {
    throw IoError(path + ": not the journal that the killed program wrote; its last rows are not saved");
  }
  return take_lock(file, path) ? std::move(file) : os::FileDescriptor();
}

std::uint64_t save_rows(GuardPage& page, const os::FileDescriptor& file) {
  if (!page.has_journal()) return 0;
  Journal journal(page, file);
  std::uint64_t saved = 0;
  if (!journal.is_ended()) {
    const std::uint64_t made = page.rows();
    const std::uint64_t oldest = made > GuardPage::kRows ? made - GuardPage::kRows : 0;
    std::string rows;
    for (std::uint64_t number = std::max(journal.end().rows, oldest); number < made; ++number, ++saved) {
      rows.append(reinterpret_cast<const char*>(page.row(number)), GuardPage::kRowSize);
      if (rows.size() < kRowsPerBlock * GuardPage::kRowSize && number + 1 < made) continue;
      journal.append(rows);
      rows.clear();
    }
    journal.cut_off();  // not before: a half-written block is written over, and the disk may be full
    journal.synchronise();
  }
  page.end_journal();
  return saved;
}

}  // namespace eha
