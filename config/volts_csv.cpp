// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/volts_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/text.hpp"

namespace eha::config {
namespace {

constexpr std::string_view kVoltsColumn = "voltage_V";
constexpr std::string_view kTimeColumn = "time_s";
/// 2.8 hours at 1 kHz, the longest table that an experiment may have.
constexpr std::size_t kMostRows = 10'000'000;
constexpr std::uintmax_t kMostBytes = std::uintmax_t{1} << 30U;  ///< of kMostRows with a dozen columns
/// Tolerance of a row's time against the grid, as a share of the step, for times rounded to decimals.
constexpr double kTimeTolerance = 1e-3;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma = line.find(',');
    std::string_view field = trimmed(line.substr(0, comma));
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = field.substr(1, field.size() - 2);
    fields.push_back(field);
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

/// Reads one file line by line.
class VoltsCsv {
 public:
  explicit VoltsCsv(const std::filesystem::path& path) : path_(path) {
    require_file();
    stream_.open(path, std::ios::binary);
  }

  VoltsFile read(const std::string& name) {
    VoltsFile file{.name = name, .volts_V = {}, .step_s = std::nullopt};
    read_header();
    for (auto line = next_line(); line; line = next_line()) {
      const std::vector<std::string_view> fields = fields_of(*line);
      const auto is_filled = [](std::string_view field) { return !field.empty(); };
      if (fields.size() > columns_ &&
          std::any_of(fields.begin() + static_cast<std::ptrdiff_t>(columns_), fields.end(), is_filled)) {
        refuse(fmt::format("expected {} fields as in the header, got {}; numbers have a decimal point, no comma",
                           columns_, fields.size()));
      }
      if (file.volts_V.size() == kMostRows) refuse(fmt::format("expected at most {} rows", kMostRows));
      file.volts_V.push_back(number(fields, volts_column_, kVoltsColumn));
      if (time_column_) {
        times_s_.push_back(number(fields, *time_column_, kTimeColumn));
        lines_.push_back(line_number_);
      }
    }
    if (stream_.bad()) throw ConfigError(fmt::format("{}: cannot be read: {}", path_.string(), error_text(errno)));
    if (file.volts_V.empty()) throw ConfigError(fmt::format("{}: expected rows of voltages, got none", path_.string()));
    if (times_s_.size() >= 2) file.step_s = even_step_s();
    return file;
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw ConfigError(fmt::format("{}:{}: {}", path_.string(), line_number_, what));
  }

  /// The next line that is neither empty nor a comment.
  std::optional<std::string_view> next_line() {
    while (stream_.getline(line_.data(), static_cast<std::streamsize>(line_.size()))) {
      ++line_number_;
      const auto taken = static_cast<std::size_t>(stream_.gcount());
      const std::string_view text = trimmed(std::string_view(line_.data(), stream_.eof() ? taken : taken - 1));
      if (!text.empty() && text.front() != '#') return text;
    }
    if (!stream_.eof() && !stream_.bad()) {
      ++line_number_;
      refuse("expected a table of numbers, got a line of more than 1 MiB; check the path");
    }
    return std::nullopt;
  }

  /// A pipe or a device may have no end, or no beginning: opening a pipe waits for its other end.
  void require_file() const {
    std::error_code ignored;
    const std::filesystem::file_status status = std::filesystem::status(path_, ignored);
    if (!std::filesystem::exists(status)) return;  // its opening says why
    if (!std::filesystem::is_regular_file(status)) {
      throw ConfigError(
          fmt::format("{}: expected a CSV file, got {}", path_.string(),
                      std::filesystem::is_directory(status) ? "a directory" : "a pipe, a socket or a device"));
    }
    if (const auto bytes = std::filesystem::file_size(path_, ignored); !ignored && bytes > kMostBytes) {
      throw ConfigError(fmt::format("{}: expected a CSV file of at most 1 GiB, got {} bytes", path_.string(), bytes));
    }
  }

  void read_header() {
    if (!stream_) {
      throw ConfigError(fmt::format("{}: cannot be read: {}; check the path", path_.string(), error_text(errno)));
    }
    const auto header = next_line();
    std::optional<std::size_t> volts_column;
    const std::vector<std::string_view> names = header ? fields_of(*header) : std::vector<std::string_view>();
    columns_ = names.size();
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == kVoltsColumn) volts_column = i;
      if (names[i] == kTimeColumn) time_column_ = i;
    }
    if (!volts_column) {
      refuse(fmt::format("expected a header row with a column {}, got {}", kVoltsColumn,
                         header ? '"' + shortened(*header, 60) + '"' : "an empty file"));
    }
    volts_column_ = *volts_column;
  }

  [[nodiscard]] double number(const std::vector<std::string_view>& fields, std::size_t column,
                              std::string_view name) const {
    const std::string_view text = column < fields.size() ? fields[column] : std::string_view();
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || text.empty() || !std::isfinite(value)) {
      refuse(fmt::format("{}: expected a finite number, got \"{}\"", name, shortened(text, 40)));
    }
    return value;
  }

  [[nodiscard]] double even_step_s() const {
    const double step_s = (times_s_.back() - times_s_.front()) / static_cast<double>(times_s_.size() - 1);
    for (std::size_t k = 0; k < times_s_.size(); ++k) {
      const double expected_s = times_s_.front() + static_cast<double>(k) * step_s;
      if (!(std::abs(times_s_[k] - expected_s) <= kTimeTolerance * step_s)) {
        throw ConfigError(fmt::format("{}:{}: {}: expected evenly spaced rows, {:.9g} s here, got {:.9g}",
                                      path_.string(), lines_[k], kTimeColumn, expected_s, times_s_[k]));
      }
    }
    return step_s;
  }

  const std::filesystem::path& path_;
  std::ifstream stream_;
  std::string line_ = std::string(kLongestTableLine + 1, '\0');
  std::size_t line_number_ = 0;
  std::size_t columns_ = 0;
  std::size_t volts_column_ = 0;
  std::optional<std::size_t> time_column_;
  std::vector<double> times_s_;
  std::vector<std::size_t> lines_;
};

}  // namespace

VoltsFile read_volts_csv(const std::filesystem::path& path, const std::string& name) {
  return VoltsCsv(path).read(name);
}

}  // namespace eha::config
