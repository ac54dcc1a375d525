// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/foreign_reader.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/record/confined_reader.hpp"

namespace eha::importer {
namespace {

using record::Answer;
using record::ConfinedReader;

constexpr std::uint64_t kMostColumns = 100'000;

/// Names and refusals go to a terminal. @returns false when the answer ends there or is none
bool take_text(ConfinedReader& reader, std::string& text) {
  if (!reader.take(text)) return false;
  text = readable(text, text.size());
  return true;
}

/// @returns false when the answer ends there or is none
bool take_arrays(ConfinedReader& reader, Arrays& arrays) {
  std::uint64_t count = 0;
  if (!take_text(reader, arrays.guess) || !take_text(reader, arrays.remark) || !reader.take(count) ||
      count > kMostColumns) {
    return false;
  }
  std::uint64_t left = kMostValues;
  for (; count > 0; --count) {
    ArrayColumn column;
    std::uint64_t single = 0;
    std::uint64_t values = 0;
    if (!take_text(reader, column.name) || !take_text(reader, column.unit) || !reader.take(single) ||
        !reader.take(values)) {
      return false;
    }
    if (values > left) return false;
    left -= values;
    column.is_single = single != 0;
    column.values.resize(values);
    if (!reader.take(column.values.data(), values * sizeof(double))) return false;
    arrays.columns.push_back(std::move(column));
  }
  return true;
}

}  // namespace

Arrays read_foreign(std::string_view kind, const std::filesystem::path& path) {
  ConfinedReader reader(kind, path);
  std::uint64_t answer = 0;
  Arrays arrays;
  std::string refusal;
  const bool is_answered = reader.take(answer);
  const bool has_arrays =
      is_answered && answer == static_cast<std::uint64_t>(Answer::arrays) && take_arrays(reader, arrays);
  const bool has_refusal =
      is_answered && answer == static_cast<std::uint64_t>(Answer::refusal) && take_text(reader, refusal);
  // One that says something else is not waited for.
  if (!has_arrays && !has_refusal && is_answered) reader.kill();
  const os::ChildEnd end = reader.wait();
  if (has_refusal) throw DataError(refusal);
  if (!has_arrays) reader.refuse(end);
  return arrays;
}

os::FileDescriptor read_workbook(const std::filesystem::path& path) {
  if (access(kWorkbookProgram, X_OK) != 0) return {};
  // A workbook of 10^6 rows of time, volts and displacement has 12 to 35 MB, takes 8 s and is 0.9 to 1.4 bytes of text
  // for each of its own; one text that many cells name is text each time.
  constexpr int kCost = 2;
  constexpr std::uint64_t kTextPerByte = 32;
  constexpr std::uint64_t kLeastText = std::uint64_t{1} << 20U;
  constexpr std::uint64_t kMostText = std::uint64_t{256} << 20U;
  ConfinedReader reader(kWorkbook, path, kCost);
  const std::uint64_t most = std::min(kMostText, kLeastText + kTextPerByte * std::min(reader.file_bytes(), kMostText));
  os::FileDescriptor text(memfd_create("eha-workbook", MFD_CLOEXEC));
  if (!text) throw IoError("cannot create a file in memory: " + error_text(errno));
  std::array<char, 65536> bytes;
  std::uint64_t total = 0;
  for (;;) {
    const std::size_t count = reader.take_some(bytes.data(), bytes.size());
    if (count == 0) break;
    total += count;
    if (total > most) {
      reader.kill();
      throw DataError(fmt::format("{}: its {} bytes unpack to more than {} MB of text; export the record as CSV",
                                  path.string(), reader.file_bytes(), most >> 20U));
    }
    record::send_bytes(text.get(), bytes.data(), count);
  }
  const os::ChildEnd end = reader.wait();
  if (end.status.value_or(1) != 0 || total == 0) {
    if (WIFSIGNALED(end.status.value_or(0))) reader.refuse(end);
    throw DataError(
        fmt::format("{}: an archive, but no workbook with a sheet of numbers; open it and save as CSV", path.string()));
  }
  lseek(text.get(), 0, SEEK_SET);
  return text;
}

void send_arrays(int descriptor, const Arrays& arrays) {
  record::send_number(descriptor, static_cast<std::uint64_t>(Answer::arrays));
  record::send_text(descriptor, arrays.guess);
  record::send_text(descriptor, arrays.remark);
  record::send_number(descriptor, arrays.columns.size());
  for (const ArrayColumn& column : arrays.columns) {
    record::send_text(descriptor, column.name);
    record::send_text(descriptor, column.unit);
    record::send_number(descriptor, column.is_single ? 1 : 0);
    record::send_number(descriptor, column.values.size());
    record::send_bytes(descriptor, column.values.data(), column.values.size() * sizeof(double));
  }
}

}  // namespace eha::importer
