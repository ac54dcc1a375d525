// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/guard_page.hpp"
#include "core/journal_block.hpp"
#include "core/os/files.hpp"
#include "daemon/acquisition/tick_record.hpp"

namespace eha::record {

/// The crash-safe form of a run, all numbers little-endian:
///
///     "EHALOG01"  u32 length  u32 crc   JSON header of that length
///     "EHAB"      u32 count   u32 index u32 crc   count x 64-byte TickRecord      (blocks, index from 0)
///     "EHAE"      u32 length  u32 index u32 crc   JSON of that length             (once, at an orderly end)
///
/// Each CRC-32C covers the bytes between the tag and the CRC, and the payload. A reader finds the next intact block
/// after damage by its tag, index and CRC.
inline constexpr std::size_t kJournalPreambleSize = 16;
inline constexpr std::size_t kJournalBlockHeaderSize = journal::kBlockHeaderSize;

/// Rows beyond those written for which a journal holds room on the disk, so that those of the loop's queue and of a
/// ramp-out fit on a disk that has filled up. It is renewed at half of them.
inline constexpr std::uint64_t kReservedRows = 65536;

/// Appends a run to a new journal. Not thread-safe. The file is locked (os::take_writer_lock) while this lives. Room on
/// the disk is reserved ahead where the file system can (fallocate), and given back at the end.
class JournalWriter {
 public:
  /// @param records_per_block  records that one write() takes; the last block may have fewer
  /// @param page  gets the position after each block, so that the guard can add the rows that the process leaves there
  ///              when it is killed; none: those rows are lost
  /// @param expected_rows  of the run: room for them and kReservedRows more is reserved
  /// @throws PermissionError, IoError  the file exists or cannot be written, or the disk has too little room
  JournalWriter(const std::filesystem::path& path, const nlohmann::ordered_json& header, std::size_t records_per_block,
                GuardPage* page = nullptr, std::uint64_t expected_rows = 0);
  JournalWriter(const JournalWriter&) = delete;
  JournalWriter& operator=(const JournalWriter&) = delete;
  ~JournalWriter();

  /// Collects records and writes every full block. @throws IoError  the blocks written before stay good, and the
  ///                                                                 others are kept for the next call
  void append(std::span<const acquisition::TickRecord> records);

  /// Writes also what waits for its block to be full, as a shorter block. @throws IoError  as append()
  void write_pending() { write_blocks(1); }

  /// Reserves room for more rows where little is left. @throws IoError  the disk is full: half of kReservedRows still
  ///                                                                    have theirs
  void keep_room();

  /// Synchronises the written blocks to the disk. @throws IoError
  void synchronise();

  /// Writes the last, shorter block and the end, and synchronises. Nothing may be appended afterwards.
  /// @throws IoError
  void finish(const nlohmann::ordered_json& end);

  [[nodiscard]] std::uint64_t rows() const noexcept { return rows_; }
  /// Rows waiting until their block is full, or for a write that succeeds.
  [[nodiscard]] std::uint64_t pending() const noexcept { return pending_.size(); }
  /// Open for reading and writing.
  [[nodiscard]] const os::FileDescriptor& file() const noexcept { return file_; }

 private:
  [[nodiscard]] std::uint64_t size_of(std::uint64_t rows) const noexcept;
  void write_blocks(std::size_t least_rows);
  void write_out();
  void reserve(std::uint64_t size);
  void give_room_back() noexcept;
  void open_to_readers_of_folder() const;
  void begin_in_page();

  std::filesystem::path path_;
  os::FileDescriptor file_;
  GuardPage* page_;
  std::size_t records_per_block_;
  std::uint32_t next_index_ = 0;
  std::uint64_t rows_ = 0;       ///< in blocks handed to the system
  std::uint64_t good_size_ = 0;  ///< bytes of the file that hold whole blocks
  std::uint64_t reserved_ = 0;   ///< bytes of the file that have room on the disk, as far as is known
  bool can_reserve_ = true;      ///< the file system can
  std::vector<acquisition::TickRecord> pending_;
  std::string buffer_;
};

/// Damage within a journal.
struct JournalGap {
  std::int64_t at_ns = 0;    ///< scheduled time of its first marked row, from the run's first tick [ns]
  std::uint64_t rows = 0;    ///< rows handed over with the flag kLost in place of the lost ones
  std::uint32_t blocks = 0;  ///< blocks lost
  std::uint64_t bytes = 0;   ///< bytes not used
};

/// The parts of a journal beside its records.
struct JournalFacts {
  nlohmann::ordered_json header;              ///< null: damaged; run.json has the same content
  std::optional<nlohmann::ordered_json> end;  ///< none when the process died during the run
  std::uint64_t rows = 0;                     ///< handed over, those with the flag kLost included
  std::uint64_t lost_rows = 0;                ///< rows with the flag kLost
  std::vector<JournalGap> gaps;
  std::uint64_t good_bytes = 0;  ///< up to the end of the last intact block, gaps included
  std::uint64_t torn_bytes = 0;  ///< after that end
};

/// Reads a journal one block at a time, in constant memory. After damage continues at the next intact block whose index
/// and tick numbers are greater than those read, and passes the rows between with the flag kLost: number and time are
/// known, volts and displacement are NaN. These rows belong to the experiment only if the rows on both sides do. Cost:
/// what follows the sums of four times the file and 64 MiB is torn.
/// @param consume  called with the records of each intact block and of each gap, in order
/// @throws DataError  neither the header nor any block is intact
/// @throws PermissionError, IoError  cannot be read
JournalFacts read_journal(const std::filesystem::path& path,
                          const std::function<void(std::span<const acquisition::TickRecord>)>& consume);

/// Whether another process is writing this journal now. Waits up to a second for a guard that adds the last rows of a
/// killed process. @throws PermissionError, IoError
[[nodiscard]] bool is_being_written(const std::filesystem::path& path);

}  // namespace eha::record
