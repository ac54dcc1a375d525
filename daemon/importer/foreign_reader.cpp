// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/foreign_reader.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "core/os/child_process.hpp"
#include "core/os/files.hpp"
#include "core/program_path.hpp"
#include "daemon/importer/column_names.hpp"

namespace eha::importer {
namespace {

constexpr std::uint64_t kMebibyte = std::uint64_t{1} << 20U;
constexpr std::uint64_t kLeastMemory = 256 * kMebibyte;  // of the program and its libraries
constexpr std::uint64_t kMostMemory = 8192 * kMebibyte;
constexpr std::uint64_t kMemoryPerByte = 150;  // compressed numbers unpack to some ten times their size
constexpr std::uint64_t kBytesPerSecond = 1'000'000;
constexpr std::chrono::seconds kLeastTime{15};
constexpr std::chrono::seconds kMostTime{600};
constexpr std::size_t kLongestText = 4096;
constexpr std::uint64_t kMostColumns = 100'000;
enum class Answer : std::uint64_t { arrays = 0x45484101, refusal = 0x45484102 };

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
  text = text.substr(0, kLongestText);
  send_number(descriptor, text.size());
  send_bytes(descriptor, text.data(), text.size());
}

/// What eha-reader sends, which is as little trusted as the file: its texts are made readable, because names and
/// refusals go to a terminal.
class Answers {
 public:
  explicit Answers(os::FileDescriptor pipe) : pipe_(std::move(pipe)) {}

  /// Each returns false when the answer ends there or is none.
  [[nodiscard]] bool take(Arrays& arrays) {
    std::uint64_t count = 0;
    if (!take(arrays.guess) || !take(arrays.remark) || !take(count) || count > kMostColumns) return false;
    std::uint64_t left = kMostValues;
    for (; count > 0; --count) {
      ArrayColumn column;
      std::uint64_t single = 0;
      std::uint64_t values = 0;
      if (!take(column.name) || !take(column.unit) || !take(single) || !take(values) || values > left) return false;
      left -= values;
      column.is_single = single != 0;
      column.values.resize(values);
      if (!take_bytes(column.values.data(), values * sizeof(double))) return false;
      arrays.columns.push_back(std::move(column));
    }
    return true;
  }
  [[nodiscard]] bool take(std::uint64_t& number) { return take_bytes(&number, sizeof number); }
  [[nodiscard]] bool take(std::string& text) {
    std::uint64_t size = 0;
    if (!take(size) || size > kLongestText) return false;
    text.resize(size);
    if (!take_bytes(text.data(), size)) return false;
    text = readable(text, kLongestText);
    return true;
  }

 private:
  [[nodiscard]] bool take_bytes(void* bytes, std::size_t size) {
    char* at = static_cast<char*>(bytes);
    while (size > 0) {
      const ssize_t count = read(pipe_.get(), at, size);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return false;
      at += count;
      size -= static_cast<std::size_t>(count);
    }
    return true;
  }

  os::FileDescriptor pipe_;
};

[[noreturn]] void refuse(const std::filesystem::path& path, std::uint64_t file_bytes, const ForeignLimits& limits,
                         const os::ChildEnd& end) {
  const int status = end.status.value_or(0);
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)) {
    throw DataError(
        fmt::format("{}: reading its {} bytes took more than {} s of processor time: damaged; save it again, or export "
                    "the record as CSV",
                    path.string(), file_bytes, limits.cpu_time.count()));
  }
  throw DataError(
      fmt::format("{}: the reader could not go on in it{}: a damaged file; save it again, or export the record as CSV",
                  path.string(), WIFSIGNALED(status) ? fmt::format(" (signal {})", WTERMSIG(status)) : ""));
}

}  // namespace

ForeignLimits limits_for(std::uint64_t file_bytes) {
  const std::chrono::seconds time = kLeastTime + std::chrono::seconds(file_bytes / kBytesPerSecond);
  return {std::min(time, kMostTime),
          kLeastMemory + std::min(file_bytes, (kMostMemory - kLeastMemory) / kMemoryPerByte) * kMemoryPerByte};
}

namespace {

/// eha-reader at a file, and the pipe that it writes to.
struct Reader {
  std::uint64_t file_bytes;
  ForeignLimits limits;
  std::unique_ptr<os::ChildProcess> process;
  os::FileDescriptor from;  ///< closed before the process is waited for, which then ends
};

Reader start_reader(std::string_view kind, const std::filesystem::path& path, int cost) {
  const os::FileDescriptor file = os::open_file(path, O_RDONLY);
  const std::filesystem::path program = find_program("eha-reader");
  if (program.empty()) throw IoError("eha-reader is not installed beside eha; install the package again");
  Reader reader{.file_bytes = std::filesystem::file_size(path), .limits = {}, .process = nullptr, .from = {}};
  reader.limits = limits_for(reader.file_bytes);
  reader.limits.cpu_time *= cost;
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw IoError("cannot create a pipe: " + error_text(errno));
  reader.from = os::FileDescriptor(ends[0]);
  const os::FileDescriptor to(ends[1]);
  const os::FileDescriptor silent = os::open_file("/dev/null", O_WRONLY);
  reader.process = std::make_unique<os::ChildProcess>(os::SpawnRequest{
      .words = {program.string(), std::string(kind), path.string(), fmt::format("{}", reader.limits.cpu_time.count()),
                fmt::format("{}", reader.limits.memory_bytes)},
      .standard_output = &to,
      .standard_error = &silent,
      .shared = &file});
  return reader;
}

}  // namespace

Arrays read_foreign(std::string_view kind, const std::filesystem::path& path) {
  Reader started = start_reader(kind, path, 1);
  os::ChildProcess& reader = *started.process;
  Answers answers(std::move(started.from));
  std::uint64_t answer = 0;
  Arrays arrays;
  std::string refusal;
  const bool is_answered = answers.take(answer);
  const bool has_arrays = is_answered && answer == static_cast<std::uint64_t>(Answer::arrays) && answers.take(arrays);
  const bool has_refusal =
      is_answered && answer == static_cast<std::uint64_t>(Answer::refusal) && answers.take(refusal);
  // One that says something else is not waited for.
  if (!has_arrays && !has_refusal && is_answered) reader.signal(SIGKILL);
  const os::ChildEnd end = reader.wait();
  if (has_refusal) throw DataError(refusal);
  if (!has_arrays) refuse(path, started.file_bytes, started.limits, end);
  return arrays;
}

os::FileDescriptor read_workbook(const std::filesystem::path& path) {
  if (access(kWorkbookProgram, X_OK) != 0) return {};
  constexpr int kCost = 10;  // an interpreted program
  constexpr std::uint64_t kMostText = std::uint64_t{2} << 30U;
  Reader reader = start_reader(kWorkbook, path, kCost);
  os::FileDescriptor text(memfd_create("eha-workbook", MFD_CLOEXEC));
  if (!text) throw IoError("cannot create a file in memory: " + error_text(errno));
  std::array<char, 65536> bytes;
  std::uint64_t total = 0;
  for (;;) {
    const ssize_t count = read(reader.from.get(), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    total += static_cast<std::uint64_t>(count);
    if (total > kMostText || !can_hold(reader.file_bytes, total, 1)) {
      reader.process->signal(SIGKILL);
      throw DataError(
          fmt::format("{}: its {} bytes unpack to more than {} MB of text: damaged; export the record as CSV",
                      path.string(), reader.file_bytes, total >> 20U));
    }
    send_bytes(text.get(), bytes.data(), static_cast<std::size_t>(count));
  }
  const os::ChildEnd end = reader.process->wait();
  if (end.status.value_or(1) != 0 || total == 0) {
    if (WIFSIGNALED(end.status.value_or(0))) refuse(path, reader.file_bytes, reader.limits, end);
    throw DataError(
        fmt::format("{}: an archive, but no workbook with a sheet of numbers; open it and save as CSV", path.string()));
  }
  lseek(text.get(), 0, SEEK_SET);
  return text;
}

void send_arrays(int descriptor, const Arrays& arrays) {
  send_number(descriptor, static_cast<std::uint64_t>(Answer::arrays));
  send_text(descriptor, arrays.guess);
  send_text(descriptor, arrays.remark);
  send_number(descriptor, arrays.columns.size());
  for (const ArrayColumn& column : arrays.columns) {
    send_text(descriptor, column.name);
    send_text(descriptor, column.unit);
    send_number(descriptor, column.is_single ? 1 : 0);
    send_number(descriptor, column.values.size());
    send_bytes(descriptor, column.values.data(), column.values.size() * sizeof(double));
  }
}

void send_refusal(int descriptor, std::string_view message) {
  send_number(descriptor, static_cast<std::uint64_t>(Answer::refusal));
  send_text(descriptor, message);
}

}  // namespace eha::importer
