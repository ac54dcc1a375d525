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
#include "daemon/importer/asked_command.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/csv_fields.hpp"

namespace eha::importer {
namespace {

constexpr std::array kPeriods = std::to_array<std::string_view>(
    {"hresolution", "increment", "sampleinterval", "samplinginterval", "deltax", "deltat", "sampleperiod",
     "samplingperiod", "sampletime", "scaninterval", "abtastzeit", "abtastintervall", "abtastperiode", "ts", "dt"});
constexpr std::array kRates =
    std::to_array<std::string_view>({"samplerate", "samplingrate", "samplefrequency", "samplingfrequency", "scanrate",
                                     "abtastrate", "abtastfrequenz", "messrate", "fs"});
constexpr std::array kRateUnits = std::to_array<std::pair<std::string_view, double>>({{"", 1.0},
                                                                                      {"hz", 1.0},
                                                                                      {"1/s", 1.0},
                                                                                      {"s/s", 1.0},
                                                                                      {"sa/s", 1.0},
                                                                                      {"samples/s", 1.0},
                                                                                      {"samples/sec", 1.0},
                                                                                      {"khz", 1e3},
                                                                                      {"ks/s", 1e3},
                                                                                      {"mhz", 1e6},
                                                                                      {"ms/s", 1e6}});

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

std::string_view trimmed(std::string_view text, std::string_view of) {
  const std::size_t begin = text.find_first_not_of(of);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(of) - begin + 1);
}

/// Rates in one of such a unit [Hz]; none when it is no unit of a rate.
std::optional<double> rate_unit_Hz(std::string_view unit) {
  std::string small(unit);
  std::transform(small.begin(), small.end(), small.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const auto& [name, rate_Hz] : kRateUnits) {
    if (small == name) return rate_Hz;
  }
  return std::nullopt;
}

/// As period_named. @param unit  behind the value; empty: as the name says
std::optional<double> period_of(std::string_view name, double value, std::string_view unit) {
  const auto [plain_name, unit_of_name] = name_and_unit(trimmed(name, " \t:=#"));
  const std::string word = plain(plain_name);
  const bool is_period = is_one_of(kPeriods, word);
  if (!(value > 0.0) || (!is_period && !is_one_of(kRates, word))) return std::nullopt;
  double period_s = is_period ? value * seconds_in(unit_of_name).value_or(1.0)
                              : 1.0 / (value * rate_unit_Hz(unit_of_name).value_or(1.0));
  const std::optional<std::string> known = known_unit(unit);
  const std::optional<double> unit_s = known ? seconds_in(*known) : std::nullopt;
  const std::optional<double> unit_Hz = unit.empty() ? std::nullopt : rate_unit_Hz(unit);
  if (is_period && unit_s) period_s = value * *unit_s;
  if (!is_period && unit_Hz) period_s = 1.0 / (value * *unit_Hz);
  return std::isfinite(period_s) ? std::optional(period_s) : std::nullopt;
}

/// "Abtastrate: 200 Hz", "# Ts = 5 ms": a name, one number, and its unit or nothing.
std::optional<double> period_in_words(std::string_view text, NumberSigns signs) {
  text = trimmed(text, " \t,;\"\r");
  const std::size_t begin = text.find_first_of("0123456789");
  if (begin == 0 || begin == std::string_view::npos) return std::nullopt;
  const std::size_t end = std::min(text.find_first_not_of("0123456789.,eE+-", begin), text.size());
  const std::string_view number = text.substr(begin, end - begin);
  const std::string_view unit = trimmed(text.substr(end), " \t[]();");
  double value = 0.0;
  const bool is_read = parse_number(number, signs, value) == NumberKind::finite ||
                       (!are_groups(number, '.') && parse_number(number, {}, value) == NumberKind::finite);
  const std::optional<std::string> known = known_unit(unit);
  if (!is_read || !(unit.empty() || rate_unit_Hz(unit) || (known && seconds_in(*known)))) return std::nullopt;
  return period_of(text.substr(0, begin), value, unit);
}

}  // namespace

std::optional<double> period_named(std::string_view name, double value) { return period_of(name, value, ""); }

std::optional<double> period_above_rows(const std::vector<std::string>& lines, const Dialect& dialect) {
  constexpr double kSame = 1e-6;
  std::optional<double> period_s;
  const std::size_t end = std::min(lines.size(), dialect.first_data_line > 0 ? dialect.first_data_line - 1 : 0);
  for (std::size_t k = 0; k < end; ++k) {
    const std::vector<std::string> fields = fields_of(lines[k], dialect.delimiter);
    const std::vector<std::string> below =
        k + 1 < end ? fields_of(lines[k + 1], dialect.delimiter) : std::vector<std::string>();
    const auto take = [&](std::optional<double> said_s) {
      const bool is_same = !said_s || !period_s || std::abs(*said_s / *period_s - 1.0) <= kSame;
      if (said_s) period_s = said_s;
      return is_same;
    };
    if (!take(period_in_words(lines[k], dialect.signs))) return std::nullopt;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      std::optional<double> value = number_at(fields, i + 1, dialect.signs);
      const std::string unit = value && i + 2 < fields.size() ? fields[i + 2] : "";
      if (!value) value = number_at(below, i, dialect.signs);
      if (value && !take(period_of(fields[i], *value, unit))) return std::nullopt;
    }
  }
  return period_s;
}

void refuse_long_log(const Dialect& dialect, const std::filesystem::path& path, const Options& options) {
  const auto column = [&](std::string_view wanted) {
    const auto is_wanted = [&](const std::string& name) { return plain(name) == wanted; };
    return std::find_if(dialect.names.begin(), dialect.names.end(), is_wanted) - dialect.names.begin() + 1;
  };
  const auto count = static_cast<std::ptrdiff_t>(dialect.names.size());
  const std::ptrdiff_t name = column("varname");
  const std::ptrdiff_t value = column("varvalue");
  const std::ptrdiff_t time = column("timems");
  if (name > count || value > count || time > count) return;
  const std::string wide = path.stem().string() + "-columns.csv";
  // Time_ms is a million times a spreadsheet's date in days.
  throw DataError(fmt::format(
      "{0}: a log with a row for each variable and time, where a column for each variable is expected; `awk -F'{1}' "
      "'NR>1&&!/[$]RT/{{gsub(/\"/,\"\");gsub(/,/,\".\",${3});gsub(/,/,\".\",${4});if(!(${2} in c)){{c[${2}]=++n;"
      "h=h\",\"${2}}}if(!(${4} in s)){{s[${4}]=++m;t[m]=${4}}}v[s[${4}],c[${2}]]=${3}}}"
      "END{{print\"time_s\"h;for(i=1;i<=m;i++){{r=sprintf(\"%.6f\",(t[i]-t[1])*0.0864);for(j=1;j<=n;j++)"
      "r=r\",\"v[i,j];print r}}}}' {6} > {5}` writes them, then: `{7}`",
      path.string(), dialect.delimiter, name, value, time, shell_word(wide), shell_word(path.string()),
      command_on(options, path, wide, kOfText, "--resample")));
}

}  // namespace eha::importer
