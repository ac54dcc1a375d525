// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/os/child_process.hpp"
#include "core/os/file_descriptor.hpp"
#include "daemon/acquisition/tick_record.hpp"

// HDF5 and matio trust what a file says of itself: a damaged or made-up one may crash them, have them ask for all
// memory, or take them over. So the program eha-reader opens such files: a process with limits and without rights.

namespace eha::record {

/// What reading a file may cost.
struct ReaderLimits {
  std::chrono::seconds cpu_time{};
  std::uint64_t memory_bytes = 0;  ///< address space
};

/// In proportion to the file: 20 s and 1 GiB for 5 MB, at most 600 s and 8 GiB.
[[nodiscard]] ReaderLimits limits_for(std::uint64_t file_bytes);

/// eha-reader at one file, and what it sends, which is as little trusted as the file. Not thread-safe.
class ConfinedReader {
 public:
  /// Starts it. @param kind  what eha-reader knows the file's kind by   @param cost  factor of the time it may take
  /// @throws IoError, PermissionError
  ConfinedReader(std::string_view kind, const std::filesystem::path& path, int cost = 1);

  // Each returns false when the answer ends there or is none.
  [[nodiscard]] bool take(void* bytes, std::size_t size);
  [[nodiscard]] bool take(std::uint64_t& number) { return take(&number, sizeof number); }
  /// At most 4096 bytes, of any value: make it readable before a terminal shows it.
  [[nodiscard]] bool take(std::string& text);
  /// What there is, at most `size` bytes. @returns 0 at the end
  [[nodiscard]] std::size_t take_some(void* bytes, std::size_t size);

  [[nodiscard]] std::uint64_t file_bytes() const noexcept { return file_bytes_; }
  /// Of processor time and memory, by what the file takes on its disk.
  [[nodiscard]] const ReaderLimits& limits() const noexcept { return limits_; }
  void kill() const noexcept;
  os::ChildEnd wait() noexcept { return process_->wait(); }
  /// Says how it ended without an answer. @throws DataError  always
  [[noreturn]] void refuse(const os::ChildEnd& end) const;

 private:
  std::filesystem::path path_;
  std::uint64_t file_bytes_;
  ReaderLimits limits_;
  std::unique_ptr<os::ChildProcess> process_;
  os::FileDescriptor from_;  ///< closed before the process is waited for, which then ends
};

/// The rows of a run's raw.h5, read by eha-reader.
/// @throws DataError  damaged, or it needs more than its limits   @throws IoError, PermissionError
[[nodiscard]] std::vector<acquisition::TickRecord> read_raw_rows(const std::filesystem::path& path);
inline constexpr std::string_view kRawRows = "raw";  ///< the kind, for eha-reader

// What eha-reader sends. @throws IoError
enum class Answer : std::uint64_t { arrays = 0x45484101, refusal = 0x45484102, rows = 0x45484103 };
void send_bytes(int descriptor, const void* bytes, std::size_t size);
void send_number(int descriptor, std::uint64_t number);
void send_text(int descriptor, std::string_view text);
void send_refusal(int descriptor, std::string_view message);
void send_rows(int descriptor, const std::vector<acquisition::TickRecord>& rows);

}  // namespace eha::record
