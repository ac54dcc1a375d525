// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/csv_columns.hpp"

#include <csv.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <new>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/text.hpp"

namespace eha::record {
namespace {

constexpr std::size_t kLongestLine = std::size_t{1} << 16U;
constexpr std::size_t kMostColumns = 1024;

struct Parser {
  Parser() {
    if (csv_init(&state, CSV_STRICT | CSV_STRICT_FINI) != 0) throw std::bad_alloc();
  }
  Parser(const Parser&) = delete;
  Parser& operator=(const Parser&) = delete;
  ~Parser() { csv_free(&state); }
  csv_parser state{};
};

/// The fields of one line. All characters are in one string, so that a line costs no allocation.
struct Fields {
  std::string text;
  std::vector<std::size_t> ends;
  [[nodiscard]] std::string_view operator[](std::size_t i) const {
    const std::size_t begin = i == 0 ? 0 : ends[i - 1];
    return std::string_view(text).substr(begin, ends[i] - begin);
  }
};

void add_field(void* field, std::size_t length, void* fields_address) {
  auto& fields = *static_cast<Fields*>(fields_address);
  fields.text.append(static_cast<const char*>(field), length);
  fields.ends.push_back(fields.text.size());
}

/// Longest name or field in a message, in characters.
constexpr std::size_t kLongestShown = 40;

std::string quoted_for_message(std::string_view text) { return '"' + shortened(text, kLongestShown) + '"'; }

/// Text that is not UTF-8 cannot be written as JSON later.
bool is_utf8(const std::string& text) {
  try {
    static_cast<void>(nlohmann::json(text).dump());
    return true;
  } catch (const nlohmann::json::type_error&) {
    return false;
  }
}

/// Digits of a decimal number that from_chars has accepted.
void note_precision(std::string_view number, CsvColumns& columns) {
  int decimals = 0;
  int significant = 0;
  bool after_point = false;
  std::size_t i = 0;
  for (; i < number.size() && number[i] != 'e' && number[i] != 'E'; ++i) {
    if (number[i] == '.') {
      after_point = true;
    } else if (number[i] >= '0' && number[i] <= '9') {
      if (after_point) ++decimals;
      if (significant > 0 || number[i] != '0') ++significant;
    }
  }
  int exponent = 0;
  if (i + 1 < number.size()) {
    const std::size_t begin = number[i + 1] == '+' ? i + 2 : i + 1;
    std::from_chars(number.data() + begin, number.data() + number.size(), exponent);
  }
  columns.time_decimals = std::max(columns.time_decimals, decimals - exponent);
  columns.time_significant = std::max(columns.time_significant, significant);
}

class Reader {
 public:
  Reader(const std::filesystem::path& path, WantedColumns wanted) : path_(path), wanted_(wanted) {}

  CsvColumns read() {
    std::error_code code;
    if (std::filesystem::is_directory(path_, code)) os::throw_system_error("read", path_, EISDIR);
    errno = 0;
    std::ifstream stream(path_, std::ios::binary);
    if (!stream) os::throw_system_error("read", path_, errno != 0 ? errno : EIO);
    std::vector<char> buffer(kLongestLine);
    while (true) {
      errno = 0;
      stream.getline(buffer.data(), static_cast<std::streamsize>(buffer.size()));
      const auto taken = static_cast<std::size_t>(stream.gcount());
      if (stream.bad()) os::throw_system_error("read", path_, errno != 0 ? errno : EIO);
      if (stream.fail() && !stream.eof()) {
        ++line_;
        fail(fmt::format("the line is longer than {} characters; this is no CSV text", kLongestLine - 1));
      }
      if (stream.fail()) break;
      ++line_;
      // getline counts the newline that it removes, and there is none at the end of a file cut short.
      take(std::string_view(buffer.data(), stream.eof() ? taken : taken - 1));
      if (stream.eof()) break;
    }
    if (line_ == 0) throw DataError(fmt::format("{}: the file is empty; {}", path_.string(), expected_header()));
    if (columns_.names.empty()) {
      throw DataError(fmt::format("{}: only comments, no header row; {}", path_.string(), expected_header()));
    }
    return std::move(columns_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw DataError(fmt::format("{}:{}: {}", path_.string(), line_, what));
  }

  [[nodiscard]] std::string expected_header() const {
    return wanted_ == WantedColumns::all ? "expected a header of three columns such as time_s,voltage_V,displacement_in"
                                         : "expected a header such as time_s,voltage_V: time first, the input last";
  }

  void take(std::string_view line) {
    if (line_ == 1 && line.substr(0, 3) == "\xEF\xBB\xBF") line.remove_prefix(3);
    // Converting line ends twice leaves two of them.
    while (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    // libcsv would end a row there, and the fields of both rows would be read as one.
    if (line.find('\r') != std::string_view::npos) {
      fail("a carriage return within the line; save the file with LF or CR LF at the end of each line");
    }
    if (line.find('\0') != std::string_view::npos) fail("a NUL byte: this is a binary file, not CSV text");
    const std::size_t first = line.find_first_not_of(" \t");
    if (first == std::string_view::npos || line[first] == '#') return;
    split(line);
    if (columns_.names.empty()) {
      take_header();
    } else {
      take_row();
    }
  }

  void split(std::string_view line) {
    fields_.text.clear();
    fields_.ends.clear();
    const bool parsed =
        csv_parse(&parser_.state, line.data(), line.size(), add_field, nullptr, &fields_) == line.size() &&
        csv_fini(&parser_.state, add_field, nullptr, &fields_) == 0;
    if (!parsed) fail(fmt::format("a quotation mark out of place in {}", quoted_for_message(line)));
    if (fields_.ends.size() > kMostColumns) fail(fmt::format("more than {} columns", kMostColumns));
  }

  void take_header() {
    columns_.header_line = line_;
    std::vector<std::string> names;
    for (std::size_t i = 0; i < fields_.ends.size(); ++i) names.emplace_back(fields_[i]);
    double number = 0.0;
    const std::string& head = names.front();
    if (std::from_chars(head.data(), head.data() + head.size(), number).ptr == head.data() + head.size() &&
        !head.empty()) {
      fail(fmt::format("the header row is missing: this row begins with the number {}; {}",
                       shortened(head, kLongestShown), expected_header()));
    }
    if (head != "time_s") {
      fail(fmt::format("expected the first column to be time_s, got {}; {}", quoted_for_message(head),
                       expected_header()));
    }
    const bool enough = wanted_ == WantedColumns::all ? names.size() == 3 : names.size() >= 2;
    if (!enough)
      fail(fmt::format("got {} column{}; {}", names.size(), names.size() == 1 ? "" : "s", expected_header()));
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i].empty()) fail(fmt::format("column {} of the header has no name; {}", i + 1, expected_header()));
      // A name appears in messages and in the files written, so no control characters.
      if (std::any_of(names[i].begin(), names[i].end(), [](unsigned char c) { return c < ' ' || c == 0x7f; })) {
        fail(fmt::format("column {} of the header is named {}; {}", i + 1, quoted_for_message(names[i]),
                         expected_header()));
      }
      if (!is_utf8(names[i])) {
        fail(fmt::format("column {} of the header is named {}, which is not UTF-8; save the file as UTF-8", i + 1,
                         quoted_for_message(names[i])));
      }
      if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]) !=
          names.begin() + static_cast<std::ptrdiff_t>(i)) {
        fail(fmt::format("two columns are named {}", quoted_for_message(names[i])));
      }
    }
    columns_.values.resize(wanted_ == WantedColumns::all ? names.size() : 2);
    columns_.names = std::move(names);
  }

  void take_row() {
    if (fields_.ends.size() != columns_.names.size()) {
      fail(fmt::format("expected {} columns as in the header, got {}", columns_.names.size(), fields_.ends.size()));
    }
    const std::size_t row = columns_.rows();
    if (columns_.line_marks.empty() ||
        line_ - columns_.line_marks.back().second != row - columns_.line_marks.back().first) {
      columns_.line_marks.emplace_back(row, line_);
    }
    const bool all = wanted_ == WantedColumns::all;
    const std::size_t wanted = columns_.values.size();
    for (std::size_t i = 0; i < wanted; ++i) {
      const std::size_t column = all || i == 0 ? i : columns_.names.size() - 1;
      columns_.values[i].push_back(number(column));
    }
  }

  double number(std::size_t column) {
    std::string_view text = fields_[column];
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || error == std::errc::invalid_argument || end != text.data() + text.size()) {
      fail(fmt::format("{}: expected a number, got {}", shortened(columns_.names[column], kLongestShown),
                       quoted_for_message(fields_[column])));
    }
    if (error != std::errc() || !std::isfinite(value)) {
      fail(fmt::format("{}: expected a finite number, got {}", shortened(columns_.names[column], kLongestShown),
                       quoted_for_message(fields_[column])));
    }
    if (column == 0) note_precision(text, columns_);
    return value;
  }

  std::filesystem::path path_;
  WantedColumns wanted_;
  Parser parser_;
  Fields fields_;
  CsvColumns columns_;
  std::size_t line_ = 0;
};

}  // namespace

std::size_t CsvColumns::line_of(std::size_t row) const {
  const auto after = std::upper_bound(line_marks.begin(), line_marks.end(), row,
                                      [](std::size_t r, const auto& mark) { return r < mark.first; });
  if (after == line_marks.begin()) return header_line;
  const auto& mark = *(after - 1);
  return mark.second + (row - mark.first);
}

CsvColumns read_csv_columns(const std::filesystem::path& path, WantedColumns wanted) {
  return Reader(path, wanted).read();
}

}  // namespace eha::record
