// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>

#include "core/os/child_process.hpp"
#include "core/os/file_descriptor.hpp"

// The program eha-hdf5 writes HDF5 and MAT-files: HDF5 alone brings some forty libraries, which every other program
// would load at its start, and HDF5 1.10 crashes after a write that failed.

namespace eha::record {

// What eha-hdf5 writes, its first argument; file_writer.cpp and hdf5_main.cpp agree on what is sent.
inline constexpr std::string_view kRawHdf5 = "raw";       ///< a run's record (raw_file.hpp)
inline constexpr std::string_view kHdf5Columns = "hdf5";  ///< columns of numbers as datasets
inline constexpr std::string_view kMatColumns = "mat";    ///< the same as variables of a MAT file of version 5

/// Has eha-hdf5 write one file, which is there under its name complete or not at all. Cost: one process
/// a file, some 40 ms of a processor. Not thread-safe.
class FileWriter {
 public:
  /// Starts eha-hdf5.
  /// @param kind        one of the above
  /// @param most_bytes  upper bound of the file's size, which the disk must have
  /// @throws IoError, PermissionError
  FileWriter(std::string_view kind, std::filesystem::path path, std::uint64_t most_bytes);
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;
  /// Without commit(): ends eha-hdf5 and removes what it has written.
  ~FileWriter();

  // Each throws IoError where eha-hdf5 has ended.
  void send(const void* bytes, std::size_t size);
  void send_number(std::uint64_t number) { send(&number, sizeof number); }
  void send_text(std::string_view text);

  /// Waits for the end of eha-hdf5, synchronises the file and gives it its name. @throws IoError
  void commit();

 private:
  [[noreturn]] void refuse() const;

  std::filesystem::path path_;
  std::filesystem::path temporary_;
  os::FileDescriptor file_;
  os::FileDescriptor to_;  ///< closed before the wait for the program, which reads to the end
  std::unique_ptr<os::ChildProcess> process_;
};

/// Receives exactly so many bytes of what was sent. @throws IoError  it ends before
void receive(int descriptor, void* bytes, std::size_t size);

}  // namespace eha::record
