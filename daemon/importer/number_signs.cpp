// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/number_signs.hpp"

#include <algorithm>

namespace eha::importer {
namespace {

constexpr std::string_view kSigns = ",.";
constexpr std::string_view kFigures = "0123456789";
constexpr std::size_t kGroup = 3;
/// A decimal column that drops zeros at the end has one whole number in a thousand. A command of few levels may have
/// some.
constexpr std::size_t kEnoughWholeNumbers = 10;

bool are_digits(std::string_view text) { return text.find_first_not_of(kFigures) == std::string_view::npos; }

}  // namespace

bool are_groups(std::string_view digits, char sign) {
  std::size_t end = digits.find(sign);
  if (end == 0 || end > kGroup || !are_digits(digits.substr(0, end))) return false;
  while (end != std::string_view::npos) {
    digits.remove_prefix(end + 1);
    end = digits.find(sign);
    if (digits.substr(0, end).size() != kGroup || !are_digits(digits.substr(0, end))) return false;
  }
  return true;
}

void SignEvidence::add(std::size_t column, std::string_view field) {
  if (!field.empty() && (field.front() == '-' || field.front() == '+')) field.remove_prefix(1);
  const std::size_t exponent = field.find_first_of("eEdD");
  std::string_view digits = field.substr(0, exponent);
  if (digits.empty() || digits.find_first_not_of("0123456789,.'") != std::string_view::npos) return;
  std::string plain;
  if (digits.find('\'') != std::string_view::npos) {
    if (!are_groups(digits.substr(0, digits.find_first_of(kSigns)), '\'')) return;
    has_apostrophes_ = true;
    plain = digits;
    std::erase(plain, '\'');
    digits = plain;
  }
  if (column >= columns_.size()) columns_.resize(column + 1);
  Numbers& numbers = columns_[column];
  const std::size_t at = digits.find_first_of(kSigns);
  if (at == std::string_view::npos) {
    numbers.has_four_digits = numbers.has_four_digits || digits.size() == kGroup + 1;
    numbers.has_five_digits = numbers.has_five_digits || digits.size() > kGroup + 1;
    std::vector<std::string>& whole = numbers.whole;
    if (digits.size() > kGroup + 1 || digits.front() == '0' || whole.size() == kEnoughWholeNumbers) return;
    if (std::find(whole.begin(), whole.end(), digits) == whole.end()) whole.emplace_back(digits);
    return;
  }
  const std::size_t sign = kSigns.find(digits[at]);
  const std::size_t last = digits.find_last_of(kSigns);
  if (last == at) {
    const bool may_be_grouped = are_groups(digits, digits[at]) && digits.front() != '0' && exponent == field.npos;
    if (!may_be_grouped) only_decimal_[sign] = true;
    if (may_be_grouped && numbers.grouped[sign].empty()) numbers.grouped[sign] = field;
    if (may_be_grouped && at == 1) numbers.groups_four_digits[sign] = true;
  } else if (digits[last] != digits[at] && are_groups(digits.substr(0, last), digits[at])) {
    only_thousands_[sign] = true;
    only_decimal_[1 - sign] = true;
  } else if (are_groups(digits, digits[at])) {
    only_thousands_[sign] = true;
  }
}

bool SignEvidence::is_grouped(std::size_t sign) const {
  return only_thousands_[sign] || std::any_of(columns_.begin(), columns_.end(),
                                              [&](const Numbers& numbers) { return !numbers.grouped[sign].empty(); });
}

bool SignEvidence::is_decimal(std::size_t sign) const {
  const auto lacks = [&](const Numbers& numbers) { return numbers.lack(sign); };
  if (only_decimal_[sign] || std::any_of(columns_.begin(), columns_.end(), lacks)) return true;
  return kSigns[sign] == '.' && delimiter_ == ',' && is_grouped(sign) && !is_grouped(0) && !only_decimal_[0];
}

const SignEvidence::Numbers* SignEvidence::column_of_thousands(std::size_t sign) const {
  const auto found = std::find_if(columns_.begin(), columns_.end(), [&](const Numbers& numbers) {
    return !numbers.grouped[sign].empty() && numbers.whole.size() == kEnoughWholeNumbers && !numbers.lack(sign);
  });
  return found == columns_.end() ? nullptr : &*found;
}

std::optional<NumberSigns> SignEvidence::proved() const {
  const bool is_decimal_comma = is_decimal(0);
  if (is_decimal_comma && is_decimal(1)) return std::nullopt;
  const char apostrophe = has_apostrophes_ ? '\'' : '\0';
  for (const std::size_t sign : {std::size_t{0}, std::size_t{1}}) {
    if (is_decimal(sign)) return NumberSigns{kSigns[sign], is_grouped(1 - sign) ? kSigns[1 - sign] : apostrophe};
  }
  for (const std::size_t sign : {std::size_t{0}, std::size_t{1}}) {
    const bool is_thousands = only_thousands_[sign] || column_of_thousands(sign) != nullptr;
    const bool is_other = only_thousands_[1 - sign] || column_of_thousands(1 - sign) != nullptr;
    if (is_thousands && !is_other) return NumberSigns{kSigns[1 - sign], kSigns[sign]};
  }
  return has_apostrophes_ && !is_grouped(0) && !is_grouped(1) ? std::optional(NumberSigns{'.', '\''}) : std::nullopt;
}

std::optional<SignEvidence::Ambiguous> SignEvidence::ambiguous() const {
  if (proved() || (is_decimal(0) && is_decimal(1))) return std::nullopt;
  for (std::size_t column = 0; column < columns_.size(); ++column) {
    for (const std::size_t sign : {std::size_t{0}, std::size_t{1}}) {
      const std::string& number = columns_[column].grouped[sign];
      if (!number.empty()) return Ambiguous{column, number, kSigns[sign]};
    }
  }
  return std::nullopt;
}

std::string SignEvidence::proof_by_whole_numbers() const {
  for (const std::size_t sign : {std::size_t{0}, std::size_t{1}}) {
    const Numbers* numbers = column_of_thousands(sign);
    if (numbers != nullptr) return numbers->whole.back() + " and " + numbers->grouped[sign];
  }
  return {};
}

bool has_thousands_separator(std::string_view field) {
  std::string digits;
  int separators = 0;
  for (const char c : field) {
    if (c == '.' || c == ',' || c == ' ' || c == '\'' || static_cast<unsigned char>(c) >= 0x80) {
      ++separators;
    } else if ((c >= '0' && c <= '9') || c == '-' || c == '+') {
      digits += c;
    } else {
      return false;
    }
  }
  return separators > 0 && digits.size() > 3;
}

}  // namespace eha::importer
