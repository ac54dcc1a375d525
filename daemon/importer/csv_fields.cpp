// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/csv_fields.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <system_error>

namespace eha::importer {
namespace {

/// libcsv trims these around a field, but not a tab that separates.
int is_blank(unsigned char c) { return c == ' ' || c == '\t' ? 1 : 0; }
int is_blank_beside_tabs(unsigned char c) { return c == ' ' ? 1 : 0; }

constexpr auto kMissingWords = std::to_array<std::string_view>(
    {"",        "nan",          "-nan",          "na",           "n/a",   "null",     "none",
     "-",       "--",           "---",           "----",         "-----", "missing",  "ovld",
     "ol",      "-ol",          "over",          "ovl",          "ovrld", "overload", "overflow",
     "ovrflow", "\xE2\x88\x9E", "-\xE2\x88\x9E", "+\xE2\x88\x9E"});
/// Of a spreadsheet, in English and in German.
constexpr auto kErrors = std::to_array<std::string_view>(
    {"#n/a", "#value!", "#num!", "#div/0!", "#ref!", "#name?", "#null!", "#nv", "#wert!", "#zahl!", "#bezug!"});
constexpr std::size_t kLongestNumber = 64;
constexpr std::string_view kExponents = "eEdD";

template <typename Words>
bool is_one_of(std::string_view field, const Words& words) {
  std::array<char, 8> lower{};
  if (field.size() > lower.size()) return false;
  std::transform(field.begin(), field.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return std::find(words.begin(), words.end(), std::string_view(lower.data(), field.size())) != words.end();
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Bytes of a no-break space at a place of a text, wide or narrow, in UTF-8 or in Latin-1; 0 for anything else.
std::size_t no_break_space(std::string_view text) {
  for (const std::string_view space : {"\xC2\xA0", "\xE2\x80\xAF", "\xA0"}) {
    if (text.starts_with(space)) return space.size();
  }
  return 0;
}

/// French thousands: "75 006,7" with a no-break space. @returns the line without those between digits
std::string without_no_break_spaces(std::string_view line) {
  std::string text;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const std::size_t space = no_break_space(line.substr(i));
    const bool is_within = space > 0 && i > 0 && is_digit(line[i - 1]) && i + space < line.size();
    if (is_within && is_digit(line[i + space])) {
      i += space - 1;
    } else {
      text += line[i];
    }
  }
  return text;
}

/// Fortran's exponent of a double: "1.0D+00" as "1.0e+00". None where the text has none.
std::optional<std::string> without_fortran_exponent(std::string_view text) {
  const std::size_t at = text.find_first_of("dD");
  if (at == std::string_view::npos || at + 1 >= text.size() || text.size() > kLongestNumber ||
      text.substr(0, at).find('.') == std::string_view::npos) {
    return std::nullopt;
  }
  std::string number(text);
  number[at] = 'e';
  return number;
}

/// Whether the digits before the decimal sign, and only they, are groups of three.
bool has_groups(std::string_view text, NumberSigns signs) {
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) text.remove_prefix(1);
  const std::string_view whole = text.substr(0, std::min(text.find(signs.decimal), text.find_first_of(kExponents)));
  return whole.find(signs.thousands) != std::string_view::npos && are_groups(whole, signs.thousands) &&
         text.find(signs.thousands, whole.size()) == std::string_view::npos;
}

}  // namespace

bool is_spreadsheet_error(std::string_view field) { return is_one_of(field, kErrors); }

CsvFields::CsvFields(char delimiter) : delimiter_(delimiter) { start_parser(); }

void CsvFields::start_parser() {
  if (csv_init(&parser_, CSV_STRICT | CSV_STRICT_FINI) != 0) throw std::bad_alloc();
  csv_set_delim(&parser_, static_cast<unsigned char>(delimiter_));
  csv_set_space_func(&parser_, delimiter_ == '\t' ? is_blank_beside_tabs : is_blank);
}

CsvFields::~CsvFields() { csv_free(&parser_); }

void CsvFields::add(void* field, std::size_t length, void* self) {
  auto& fields = *static_cast<CsvFields*>(self);
  fields.text_.append(static_cast<const char*>(field), length);
  fields.ends_.push_back(fields.text_.size());
}

namespace {

/// The minus sign of typesetters, which some programs write before numbers.
constexpr std::string_view kMinus = "\xE2\x88\x92";

std::string with_plain_minus(std::string_view line) {
  std::string plain(line);
  for (std::size_t at = plain.find(kMinus); at != std::string::npos; at = plain.find(kMinus, at + 1)) {
    plain.replace(at, kMinus.size(), "-");
  }
  return plain;
}

/// `x ["]` as `x [in]`; empty where a line has none such.
std::string with_inches_named(std::string_view line) {
  std::string named(line);
  for (const auto& [sign, name] : {std::pair("[\"]", "[in]"), {"(\")", "(in)"}}) {
    for (std::size_t at = named.find(sign); at != std::string::npos; at = named.find(sign)) named.replace(at, 3, name);
  }
  return named == line ? "" : named;
}

}  // namespace

bool CsvFields::split(std::string_view line) {
  if (line.find_first_of("\xA0\xAF") != std::string_view::npos) {
    cleaned_ = without_no_break_spaces(line);
    line = cleaned_;
  }
  if (line.find(kMinus) != std::string_view::npos) {
    cleaned_ = with_plain_minus(line);
    line = cleaned_;
  }
  text_.clear();
  ends_.clear();
  if (delimiter_ != ' ') {
    if (csv_parse(&parser_, line.data(), line.size(), add, nullptr, this) == line.size() &&
        csv_fini(&parser_, add, nullptr, this) == 0) {
      return true;
    }
    // The parser keeps the state of the fault.
    csv_free(&parser_);
    start_parser();
    text_.clear();
    ends_.clear();
    // As a unit in brackets the sign is no quotation mark.
    std::string named = with_inches_named(line);
    return !named.empty() && split(named);
  }
  while (true) {
    const std::size_t begin = line.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return true;
    const bool is_quoted = line[begin] == '"' && line.find('"', begin + 1) != std::string_view::npos;
    const std::size_t from = is_quoted ? begin + 1 : begin;
    const std::size_t end = is_quoted ? line.find('"', from) : std::min(line.find_first_of(" \t", from), line.size());
    text_.append(line.substr(from, end - from));
    ends_.push_back(text_.size());
    line.remove_prefix(is_quoted ? end + 1 : end);
  }
}

NumberKind parse_number(std::string_view field, NumberSigns signs, double& value) {
  value = std::numeric_limits<double>::quiet_NaN();
  std::string_view text = field;
  std::array<char, kLongestNumber> with_point{};
  if (signs.thousands != '\0' && text.size() <= with_point.size() && has_groups(text, signs)) {
    const auto end = std::remove_copy(text.begin(), text.end(), with_point.begin(), signs.thousands);
    std::replace(with_point.begin(), end, signs.decimal, '.');
    text = std::string_view(with_point.data(), static_cast<std::size_t>(end - with_point.begin()));
  } else if (signs.decimal != '.') {
    if (text.size() > with_point.size() || text.find('.') != std::string_view::npos || text.ends_with(signs.decimal)) {
      return NumberKind::none;
    }
    std::replace_copy(text.begin(), text.end(), with_point.begin(), signs.decimal, '.');
    text = std::string_view(with_point.data(), text.size());
  }
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc::invalid_argument && end == text.data() + text.size() && !text.empty()) {
    if (error == std::errc() && std::isfinite(number)) {
      value = number;
      return NumberKind::finite;
    }
    return std::isnan(number) && error == std::errc() ? NumberKind::missing : NumberKind::not_finite;
  }
  if (const auto number_text = without_fortran_exponent(text)) return parse_number(*number_text, {}, value);
  return is_one_of(field, kMissingWords) || is_spreadsheet_error(field) ? NumberKind::missing : NumberKind::none;
}

Precision precision_of(std::string_view field, char decimal) {
  Precision precision;
  bool after_point = false;
  std::size_t i = 0;
  for (; i < field.size() && kExponents.find(field[i]) == std::string_view::npos; ++i) {
    if (field[i] == decimal) {
      after_point = true;
    } else if (field[i] >= '0' && field[i] <= '9') {
      if (after_point) ++precision.decimals;
      if (precision.significant > 0 || field[i] != '0') ++precision.significant;
    }
  }
  int exponent = 0;
  if (i + 1 < field.size()) {
    const std::size_t begin = field[i + 1] == '+' ? i + 2 : i + 1;
    std::from_chars(field.data() + begin, field.data() + field.size(), exponent);
  }
  precision.decimals -= exponent;
  return precision;
}

}  // namespace eha::importer
