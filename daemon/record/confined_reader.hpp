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

// HDF5 and matio trust the content of a file: a damaged or crafted one may crash them, make them request all memory, or
// execute code. Therefore the program eha-reader opens such files: a process with limits and without rights.

namespace eha::record {

/// Limits of processor time and memory for reading a file.
struct ReaderLimits {
  std::chrono::seconds cpu_time{};
  std::uint64_t memory_bytes = 0;  ///< address space
};

/// Returns limits in proportion to the file: 20 s and 1 GiB for 5 MB, at most 600 s and 8 GiB.
[[nodiscard]] ReaderLimits limits_for(std::uint64_t file_bytes);

/// Runs eha-reader on one file and receives its answer, which is as untrusted as the file. Not thread-safe.
class ConfinedReader {
 public:
  /// Starts eha-reader. @param kind  kind of file, for eha-reader   @param cost  factor of the allowed time
  /// @throws IoError, PermissionError
  ConfinedReader(std::string_view kind, const std::filesystem::path& path, int cost = 1);

  // Each returns false if the answer ends there or is none.
  [[nodiscard]] bool take(void* bytes, std::size_t size);
  [[nodiscard]] bool take(std::uint64_t& number) { return take(&number, sizeof number); }
  /// Receives at most 4096 bytes of any value: make the text printable before showing it on a terminal.
  [[nodiscard]] bool take(std::string& text);
  /// Receives the available bytes, at most `size`. @returns 0 at the end
  [[nodiscard]] std::size_t take_some(void* bytes, std::size_t size);

  [[nodiscard]] std::uint64_t file_bytes() const noexcept { return file_bytes_; }
  /// Limits of processor time and memory, from the file's size on disk.
  [[nodiscard]] const ReaderLimits& limits() const noexcept { return limits_; }
  void kill() const noexcept;
  os::ChildEnd wait() noexcept { return process_->wait(); }
  /// Throws the error of a process that ended without an answer. @throws DataError  always
  [[noreturn]] void refuse(const os::ChildEnd& end) const;

 private:
  std::filesystem::path path_;
  std::uint64_t file_bytes_;
  ReaderLimits limits_;
  std::unique_ptr<os::ChildProcess> process_;
  os::FileDescriptor from_;  ///< closed before the wait for the process, which ends it
};

/// The rows of a run's raw.h5, read by eha-reader.
/// @throws DataError  damaged, or it needs more than its limits   @throws IoError, PermissionError
[[nodiscard]] std::vector<acquisition::TickRecord> read_raw_rows(const std::filesystem::path& path);
inline constexpr std::string_view kRawRows = "raw";  ///< the kind, for eha-reader

// Messages of eha-reader. @throws IoError
enum class Answer : std::uint64_t { arrays = 0x45484101, refusal = 0x45484102, rows = 0x45484103 };
void send_bytes(int descriptor, const void* bytes, std::size_t size);
void send_number(int descriptor, std::uint64_t number);
void send_text(int descriptor, std::string_view text);
void send_refusal(int descriptor, std::string_view message);
void send_rows(int descriptor, const std::vector<acquisition::TickRecord>& rows);

}  // namespace eha::record
