// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/confined_reader.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <type_traits>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/program_path.hpp"
#include "core/terminal_text.hpp"

namespace eha::record {
namespace {

using acquisition::TickRecord;

constexpr std::uint64_t kMebibyte = std::uint64_t{1} << 20U;
constexpr std::uint64_t kLeastMemory = 256 * kMebibyte;  // of the program and its libraries
constexpr std::uint64_t kMostMemory = 8192 * kMebibyte;
constexpr std::uint64_t kMemoryPerByte = 150;  // compressed numbers unpack to some ten times their size
constexpr std::uint64_t kBytesPerSecond = 1'000'000;
constexpr std::chrono::seconds kLeastTime{15};
constexpr std::chrono::seconds kMostTime{600};
constexpr std::size_t kLongestSentText = 4096;

constexpr std::uint64_t kMostCompression = 16;  // of a file system that compresses

static_assert(std::is_trivially_copyable_v<TickRecord>, "rows are sent as they are in memory");

/// Returns the size of a file on disk, without its holes.
std::uint64_t allocated_bytes(const os::FileDescriptor& file) {
  constexpr std::uint64_t kBlock = 512;  // unit of st_blocks on every file system
  struct stat facts {};
  if (fstat(file.get(), &facts) != 0) return 0;
  return kBlock * static_cast<std::uint64_t>(facts.st_blocks);
}

}  // namespace

ReaderLimits limits_for(std::uint64_t file_bytes) {
  const std::chrono::seconds time = kLeastTime + std::chrono::seconds(file_bytes / kBytesPerSecond);
  return {std::min(time, kMostTime),
          kLeastMemory + std::min(file_bytes, (kMostMemory - kLeastMemory) / kMemoryPerByte) * kMemoryPerByte};
}

ConfinedReader::ConfinedReader(std::string_view kind, const std::filesystem::path& path, int cost)
    : path_(os::shown(path)) {
  const os::FileDescriptor file = os::open_regular_file(path);
  const std::filesystem::path program = find_program("eha-reader");
  if (program.empty()) throw IoError("eha-reader is not installed beside eha; install the package again");
  file_bytes_ = std::filesystem::file_size(path);
  limits_ = limits_for(std::min(file_bytes_, kMostCompression * allocated_bytes(file)));
  limits_.cpu_time *= cost;
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw IoError("cannot create a pipe: " + error_text(errno));
  from_ = os::FileDescriptor(ends[0]);
  const os::FileDescriptor to(ends[1]);
  const os::FileDescriptor silent = os::open_file("/dev/null", O_WRONLY);
  process_ = std::make_unique<os::ChildProcess>(
      os::SpawnRequest{.words = {program.string(), std::string(kind), path_.string(),
                                 fmt::format("{}", limits_.cpu_time.count()), fmt::format("{}", limits_.memory_bytes)},
                       .standard_output = &to,
                       .standard_error = &silent,
                       .shared = &file});
}

std::size_t ConfinedReader::take_some(void* bytes, std::size_t size) {
  for (;;) {
    const ssize_t count = read(from_.get(), bytes, size);
    if (count < 0 && errno == EINTR) continue;
    return count <= 0 ? 0 : static_cast<std::size_t>(count);
  }
}

bool ConfinedReader::take(void* bytes, std::size_t size) {
  char* at = static_cast<char*>(bytes);
  while (size > 0) {
    const std::size_t count = take_some(at, size);
    if (count == 0) return false;
    at += count;
    size -= count;
  }
  return true;
}

bool ConfinedReader::take(std::string& text) {
  std::uint64_t size = 0;
  if (!take(size) || size > kLongestSentText) return false;
  text.resize(size);
  return take(text.data(), size);
}

void ConfinedReader::kill() const noexcept { process_->signal(SIGKILL); }

void ConfinedReader::refuse(const os::ChildEnd& end) const {
  const int status = end.status.value_or(0);
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)) {
    throw DataError(
        fmt::format("{}: reading its {} bytes took more than {} s of processor time: damaged; save it again, or export "
                    "the record as CSV",
                    path_.string(), file_bytes_, limits_.cpu_time.count()));
  }
  throw DataError(
      fmt::format("{}: the reader could not go on in it{}: a damaged file; save it again, or export the record as CSV",
                  path_.string(), WIFSIGNALED(status) ? fmt::format(" (signal {})", WTERMSIG(status)) : ""));
}

std::vector<TickRecord> read_raw_rows(const std::filesystem::path& path) {
  ConfinedReader reader(kRawRows, path);
  std::uint64_t answer = 0;
  std::uint64_t count = 0;
  std::string refusal;
  std::vector<TickRecord> rows;
  const bool is_answered = reader.take(answer);
  bool has_rows = is_answered && answer == static_cast<std::uint64_t>(Answer::rows) && reader.take(count);
  // A row takes more than a byte of the file.
  if (has_rows && count <= reader.file_bytes()) {
    rows.resize(count);
    has_rows = reader.take(rows.data(), count * sizeof(TickRecord));
  } else {
    has_rows = false;
  }
  const bool has_refusal = is_answered && answer == static_cast<std::uint64_t>(Answer::refusal) && reader.take(refusal);
  // Does not wait for a process that sends something else.
  if (!has_rows && !has_refusal && is_answered) reader.kill();
  const os::ChildEnd end = reader.wait();
  if (has_refusal) throw DataError(terminal_text(refusal));
  if (!has_rows) reader.refuse(end);
  return rows;
}

void send_bytes(int descriptor, const void* bytes, std::size_t size) {
  const char* at = static_cast<const char*>(bytes);
  while (size > 0) {
    const ssize_t written = write(descriptor, at, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) throw IoError("cannot hand over what was read: " + error_text(errno));
    at += written;
    size -= static_cast<std::size_t>(written);
  }
}

void send_number(int descriptor, std::uint64_t number) { send_bytes(descriptor, &number, sizeof number); }

void send_text(int descriptor, std::string_view text) {
  text = text.substr(0, kLongestSentText);
  send_number(descriptor, text.size());
  send_bytes(descriptor, text.data(), text.size());
}

void send_refusal(int descriptor, std::string_view message) {
  send_number(descriptor, static_cast<std::uint64_t>(Answer::refusal));
  send_text(descriptor, message);
}

void send_rows(int descriptor, const std::vector<TickRecord>& rows) {
  send_number(descriptor, static_cast<std::uint64_t>(Answer::rows));
  send_number(descriptor, rows.size());
  send_bytes(descriptor, rows.data(), rows.size() * sizeof(TickRecord));
}

}  // namespace eha::record
