// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/number_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <system_error>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/text.hpp"

namespace eha::record {
namespace {

constexpr std::size_t kMostNameLength = 60;

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0;;) {
    const std::size_t end = line.find(',', begin);
    fields.push_back(line.substr(begin, end - begin));
    if (end == std::string_view::npos) return fields;
    begin = end + 1;
  }
}

/// Names of a header row, which may be in quotes (csv_field.hpp).
std::vector<std::string> names_of(std::string_view line) {
  std::vector<std::string> names(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const bool is_doubled = is_quoted && line[i] == '"' && i + 1 < line.size() && line[i + 1] == '"';
    if (is_doubled) {
      names.back() += line[i++];
    } else if (line[i] == '"') {
      is_quoted = !is_quoted;
    } else if (line[i] == ',' && !is_quoted) {
      names.emplace_back();
    } else {
      names.back() += line[i];
    }
  }
  return names;
}

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path) {}

  void take(std::string_view line) {
    ++line_;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty() || line.front() == '#') return;
    if (table_.names.empty()) {
      table_.names = names_of(line);
      table_.columns.resize(table_.names.size());
      return;
    }
    const std::vector<std::string_view> fields = fields_of(line);
    if (fields.size() != table_.names.size()) {
      fail(fmt::format("{} fields, expected {} as in the header", fields.size(), table_.names.size()));
    }
    for (std::size_t i = 0; i < fields.size(); ++i) table_.columns[i].push_back(number(fields[i], i));
  }

  NumberTable finish() {
    if (table_.rows() == 0) fail("the end of the file; expected a header row and rows of numbers");
    return std::move(table_);
  }

 private:
  double number(std::string_view field, std::size_t column) const {
    if (field.empty()) return std::numeric_limits<double>::quiet_NaN();
    double value = 0.0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc() || end != field.data() + field.size()) {
      fail(fmt::format("{}: \"{}\" is no number", shortened(table_.names[column], kMostNameLength),
                       shortened(field, kMostNameLength)));
    }
    return value;
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw DataError(fmt::format("{}:{}: {}", os::shown(path_), line_, what));
  }

  const std::filesystem::path& path_;
  std::size_t line_ = 0;
  NumberTable table_;
};

}  // namespace

const std::vector<double>* NumberTable::find(std::string_view name) const {
  const auto at = std::find(names.begin(), names.end(), name);
  return at == names.end() ? nullptr : &columns[static_cast<std::size_t>(at - names.begin())];
}

NumberTable read_number_table(const std::filesystem::path& path) {
  Reader reader(path);
  std::string line;
  os::read_in_pieces(path, [&](std::string_view piece) {
    for (std::size_t end = piece.find('\n'); end != std::string_view::npos; end = piece.find('\n')) {
      line += piece.substr(0, end);
      reader.take(line);
      line.clear();
      piece.remove_prefix(end + 1);
    }
    line += piece;
    if (line.size() > kLongestTableLine) {
      throw DataError(os::shown(path) + ": a line of more than 1 MiB, where a table of numbers is expected");
    }
  });
  if (!line.empty()) reader.take(line);
  return reader.finish();
}

}  // namespace eha::record
