// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/header_facts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string_view>

#include "core/error.hpp"
#include "core/shell_word.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/csv_fields.hpp"

namespace eha::importer {
namespace {

constexpr std::array kPeriods =
    std::to_array<std::string_view>({"hresolution", "increment", "sampleinterval", "samplinginterval", "deltax",
                                     "deltat", "sampleperiod", "samplingperiod", "sampletime", "ts", "dt"});
constexpr std::array kRates =
    std::to_array<std::string_view>({"samplerate", "samplingrate", "samplingfrequency", "fs"});

/// "Sample Interval:" as "sampleinterval".
std::string plain(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (std::isalpha(static_cast<unsigned char>(c)) != 0) {
      result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return result;
}

template <std::size_t N>
bool is_one_of(const std::array<std::string_view, N>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<std::string> fields_of(const std::string& line, char delimiter) {
  CsvFields splitter(delimiter);
  std::vector<std::string> fields;
  if (!splitter.split(line)) return fields;
  for (std::size_t i = 0; i < splitter.size(); ++i) fields.emplace_back(splitter[i]);
  return fields;
}

/// The positive number of a field; none for anything else.
std::optional<double> number_at(const std::vector<std::string>& fields, std::size_t i, NumberSigns signs) {
  double value = 0.0;
  if (i >= fields.size() || parse_number(fields[i], signs, value) != NumberKind::finite) return std::nullopt;
  return value > 0.0 ? std::optional(value) : std::nullopt;
}

}  // namespace

std::optional<double> period_named(std::string_view name, double value) {
  const auto [plain_name, unit] = name_and_unit(name);
  const std::string word = plain(plain_name);
  const bool is_period = is_one_of(kPeriods, word);
  if (!(value > 0.0) || (!is_period && !is_one_of(kRates, word))) return std::nullopt;
  const double period_s = is_period ? value * seconds_in(unit).value_or(1.0) : 1.0 / value;
  return std::isfinite(period_s) ? std::optional(period_s) : std::nullopt;
}

std::optional<double> period_above_rows(const std::vector<std::string>& lines, const Dialect& dialect) {
  constexpr double kSame = 1e-6;
  std::optional<double> period_s;
  const std::size_t end = std::min(lines.size(), dialect.first_data_line > 0 ? dialect.first_data_line - 1 : 0);
  for (std::size_t k = 0; k < end; ++k) {
    const std::vector<std::string> fields = fields_of(lines[k], dialect.delimiter);
    const std::vector<std::string> below =
        k + 1 < end ? fields_of(lines[k + 1], dialect.delimiter) : std::vector<std::string>();
    for (std::size_t i = 0; i < fields.size(); ++i) {
      std::optional<double> value = number_at(fields, i + 1, dialect.signs);
      if (!value) value = number_at(below, i, dialect.signs);
      const std::optional<double> said_s = value ? period_named(fields[i], *value) : std::nullopt;
      if (!said_s) continue;
      if (period_s && std::abs(*said_s / *period_s - 1.0) > kSame) return std::nullopt;
      period_s = said_s;
    }
  }
  return period_s;
}

void refuse_long_log(const Dialect& dialect, const std::filesystem::path& path) {
  const auto column = [&](std::string_view wanted) {
    const auto is_wanted = [&](const std::string& name) { return plain(name) == wanted; };
    return std::find_if(dialect.names.begin(), dialect.names.end(), is_wanted) - dialect.names.begin() + 1;
  };
  const auto count = static_cast<std::ptrdiff_t>(dialect.names.size());
  const std::ptrdiff_t name = column("varname");
  const std::ptrdiff_t value = column("varvalue");
  const std::ptrdiff_t time = column("timems");
  if (name > count || value > count || time > count) return;
  const std::string wide = shell_word(path.stem().string() + "-columns.csv");
  // Time_ms is a million times a spreadsheet's date in days.
  throw DataError(fmt::format(
      "{0}: a log with a row for each variable and time, where a column for each variable is expected; `awk -F'{1}' "
      "'NR>1&&!/[$]RT/{{gsub(/\"/,\"\");gsub(/,/,\".\",${3});gsub(/,/,\".\",${4});if(!(${2} in c)){{c[${2}]=++n;"
      "h=h\",\"${2}}}if(!(${4} in s)){{s[${4}]=++m;t[m]=${4}}}v[s[${4}],c[${2}]]=${3}}}"
      "END{{print\"time_s\"h;for(i=1;i<=m;i++){{r=sprintf(\"%.6f\",(t[i]-t[1])*0.0864);for(j=1;j<=n;j++)"
      "r=r\",\"v[i,j];print r}}}}' {6} > {5}` writes them, then: `{7}`",
      path.string(), dialect.delimiter, name, value, time, wide, shell_word(path.string()),
      fmt::format("eha import {} --resample", wide)));
}

}  // namespace eha::importer
