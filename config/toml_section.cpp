// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/toml_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "config/volts_csv.hpp"
#include "core/error.hpp"
#include "core/range_text.hpp"
#include "core/terminal_text.hpp"
#include "core/text.hpp"

namespace eha::config {
namespace {

constexpr std::size_t kLongestStem = 64;

Position place(const toml::source_region& source) {
  return {std::max<std::uint32_t>(1, source.begin.line), std::max<std::uint32_t>(1, source.begin.column)};
}

/// Formats a value for a message.
std::string shown(const toml::node& node) {
  constexpr std::size_t kLongest = 40;
  if (const auto* text = node.as_string()) return '"' + shortened(text->get(), kLongest) + '"';
  if (const auto* number = node.as_integer()) return fmt::format("{}", number->get());
  if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  if (node.is_table()) return "a table";
  if (node.is_array()) return "an array";
  return "a date or time";
}

/// toml++ destroys nested tables recursively, and each dot of a key nests one table: 20 000 overflow the stack. The
/// library's limit of 256 nested values and this limit on a line prevent that.
constexpr std::size_t kMostDots = 25;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Counts the dots of a line except those in numbers; at least half of those in dotted keys that look like numbers.
std::size_t count_dots(std::string_view line) {
  std::size_t count = 0;
  for (std::size_t dot = line.find('.'); dot != std::string_view::npos; dot = line.find('.', dot + 1)) {
    std::size_t end = dot + 1;
    while (end < line.size() && is_digit(line[end])) ++end;
    const bool in_number =
        dot > 0 && is_digit(line[dot - 1]) && end > dot + 1 && (end == line.size() || line[end] != '.');
    if (!in_number) ++count;
  }
  return count;
}

void refuse_many_dots(std::string_view text, const std::string& file_name) {
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (count_dots(text.substr(0, end)) > kMostDots) {
      throw ConfigError(fmt::format("{}:{}:1: expected at most {} dots outside of numbers in a line, got more",
                                    file_name, line, kMostDots));
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

bool is_stem_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '_' || c == '-';
}

bool is_file_stem(std::string_view text) {
  return !text.empty() && text.size() <= kLongestStem && std::all_of(text.begin(), text.end(), is_stem_character) &&
         text.front() != '.' && text.front() != '_' && text.front() != '-';
}

std::string quoted_list(const std::vector<std::string_view>& names) {
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) list += i + 1 == names.size() ? " or " : ", ";
    list += '"' + std::string(names[i]) + '"';
  }
  return list;
}

/// The line of a text in which the parser stopped.
std::string_view line_at(std::string_view text, const Position& at) {
  for (std::size_t line = 1; line < at.line && !text.empty(); ++line) {
    text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + 1);
  }
  return text.substr(0, text.find_first_of("\r\n"));
}

/// Returns the correction for a decimal comma ("20,0" for "20.0"); empty elsewhere. @param at  where the parser stopped
std::string decimal_comma(std::string_view text, const Position& at) {
  text = line_at(text, at);
  std::size_t comma = at.column - 1;
  const auto is_digit = [&](std::size_t i) { return i < text.size() && text[i] >= '0' && text[i] <= '9'; };
  // Within braces the parser stops behind the digits, which it takes for a key.
  if (at.column >= 2 && comma < text.size() && text[comma] != '=') {
    std::size_t digits = comma;
    while (digits > 0 && is_digit(digits - 1)) --digits;
    if (digits < comma && digits > 0 && text[digits - 1] == ',') comma = digits - 1;
  }
  if (comma < 1 || at.column < 2 || comma >= text.size() || text[comma] != ',' || !is_digit(comma - 1) ||
      !is_digit(comma + 1)) {
    return {};
  }
  std::size_t begin = comma;
  std::size_t end = comma + 1;
  while (begin > 0 && is_digit(begin - 1)) --begin;
  if (begin > 0 && (text[begin - 1] == '-' || text[begin - 1] == '+')) --begin;
  while (is_digit(end)) ++end;
  return fmt::format("; a decimal comma? Write {}.{}", text.substr(begin, comma - begin),
                     text.substr(comma + 1, end - comma - 1));
}

std::string_view without_blanks(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// Says of a line whose value is a word without quotes, or no value, what is written and what to write; empty
/// elsewhere.
std::string wrong_value(std::string_view text, const Position& at) {
  const std::string_view line = line_at(text, at);
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos || line.find_first_of("\"'[{#") < equals) return {};
  const std::string_view key = without_blanks(line.substr(0, equals));
  const std::string_view value = without_blanks(line.substr(equals + 1, line.find('#', equals) - equals - 1));
  if (key.empty()) return {};
  if (value.empty()) return fmt::format("\"{} =\" has no value; write one behind the =", shortened(key, 60));
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  if (!is_letter(value.front()) || value.find_first_of("\"'\\") != std::string_view::npos) return {};
  for (const std::string_view word : {"true", "false"}) {
    const bool is_word =
        value.size() == word.size() && std::equal(value.begin(), value.end(), word.begin(), [](char a, char b) {
          return (a >= 'A' && a <= 'Z' ? static_cast<char>(a - 'A' + 'a') : a) == b;
        });
    // As it should be: the fault is another one.
    if (value == word) return {};
    if (is_word) return fmt::format("{} has the value {}; write {} = {}", shortened(key, 60), value, key, word);
  }
  if (value == "inf" || value == "nan" || key.find_first_of(" \t") != std::string_view::npos) return {};
  return fmt::format("{0} has the value {1} without quotes; a text needs them: {0} = \"{1}\"", shortened(key, 60),
                     shortened(value, 60));
}

}  // namespace

void add_fault(Document& document, const std::string& path, std::string_view expected, std::string_view got) {
  document.issues.add(position_of(document.positions, path), path, expected, got);
}

Document parse_document(std::string_view text, const std::string& file_name, NamedFiles named_files) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    throw ConfigError(file_name +
                      ": expected a configuration file, got an empty one; start from one of the shipped ones");
  }
  if (text.find('\0') != std::string_view::npos) {
    throw ConfigError(file_name + ": expected a configuration file in TOML, got a binary file");
  }
  refuse_many_dots(text, file_name);
  try {
    return {toml::parse(text, file_name), IssueList(file_name), {}, file_name, named_files};
  } catch (const toml::parse_error& error) {
    const Position position = place(error.source());
    if (const std::string wrong = wrong_value(text, position); !wrong.empty()) {
      throw ConfigError(fmt::format("{}:{}:{}: expected TOML: {}", file_name, position.line, position.column, wrong));
    }
    throw ConfigError(fmt::format("{}:{}:{}: expected TOML, got a syntax error: {}{}", file_name, position.line,
                                  position.column, shortened(error.description(), 200), decimal_comma(text, position)));
  }
}

Section::Section(const toml::table& table, std::string path, Document& document)
    : table_(&table), path_(std::move(path)), document_(&document) {
  if (!path_.empty()) document_->positions[path_] = place(table.source());
}

std::string Section::path(std::string_view key) const {
  return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
}

void Section::wrong(std::string_view key, const toml::node& node, std::string_view expected) {
  document_->issues.add(place(node.source()), path(key), expected, shown(node));
}

const toml::node* Section::find(std::string_view key, std::string_view expected, Need need) {
  known_.push_back(key);
  const toml::node* node = table_->get(key);
  if (node != nullptr) {
    document_->positions[path(key)] = place(node->source());
  } else if (need == Need::required) {
    const Position position = path_.empty() ? Position{} : place(table_->source());
    // Its keys are commented out for a valve that is to be measured anew.
    const bool is_bare = table_->empty() && path_ == "following";
    document_->issues.add(position, path(key), expected,
                          is_bare ? "a table without keys; leave the line [following] out, too" : "no such key");
  }
  return node;
}

void Section::number_in_millimetres(std::string_view key, const MillimetreKey& written, const toml::node& node,
                                    double& target, const Range& range) {
  known_.push_back(key);
  const Position position = place(node.source());
  document_->positions[path(key)] = document_->positions[path(written.name)] = position;
  if (table_->contains(key)) {
    document_->issues.add_text(position, path(written.name),
                               fmt::format("the same as {}; leave out one of the two", path(key)));
    if (const auto value = node.value<double>()) target = *value * written.factor;  // no other fault follows from it
    return;
  }
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (value && range.contains(*value * written.factor)) {
    target = *value * written.factor;
    return;
  }
  Range in_millimetres = range;
  in_millimetres.low /= written.factor;
  in_millimetres.high /= written.factor;
  wrong(written.name, node, describe(in_millimetres));
}

void Section::number(std::string_view key, double& target, const Range& range, Need need) {
  if (auto written = millimetre_key(key)) {
    const toml::node* node = table_->get(written->name);
    millimetre_keys_.push_back(written->name);
    if (node != nullptr) return number_in_millimetres(key, *written, *node, target, range);
  }
  const std::string expected = describe(range);
  const toml::node* node = find(key, expected, need);
  if (node == nullptr) return;
  const auto value = node->is_number() ? node->value<double>() : std::nullopt;
  if (value && range.contains(*value)) {
    target = *value;
  } else {
    wrong(key, *node, expected);
  }
}

void Section::number(std::string_view key, std::optional<double>& target, const Range& range) {
  double value = std::numeric_limits<double>::quiet_NaN();
  number(key, value, range, Need::optional);
  if (std::isfinite(value)) target = value;
}

void Section::number_or_unknown(std::string_view key, std::optional<double>& target) {
  constexpr std::string_view kExpected = "a number or \"unknown\"";
  const toml::node* node = find(key, kExpected, Need::required);
  if (node == nullptr) return;
  const auto value = node->value<double>();
  if (node->is_number() && value && std::isfinite(*value)) {
    target = *value;
  } else if (const auto* word = node->as_string(); word == nullptr || word->get() != "unknown") {
    wrong(key, *node, kExpected);
  }
}

std::optional<std::int64_t> Section::whole_number(std::string_view key, std::int64_t low, std::int64_t high,
                                                  Need need) {
  const std::string expected = describe_integers(low, high);
  const toml::node* node = find(key, expected, need);
  if (node == nullptr) return std::nullopt;
  const auto* value = node->as_integer();
  if (value != nullptr && value->get() >= low && value->get() <= high) return value->get();
  wrong(key, *node, expected);
  return std::nullopt;
}

void Section::boolean(std::string_view key, bool& target, Need need) {
  const toml::node* node = find(key, "true or false", need);
  if (node == nullptr) return;
  if (const auto* value = node->as_boolean()) {
    target = value->get();
  } else {
    wrong(key, *node, "true or false");
  }
}

void Section::boolean(std::string_view key, std::optional<bool>& target) {
  bool value = false;
  if (!has(key)) return ignore(key);
  boolean(key, value);
  target = value;
}

const std::string* Section::find_text(std::string_view key, Need need) {
  const toml::node* node = find(key, "a string", need);
  if (node == nullptr) return nullptr;
  const auto* value = node->as_string();
  if (value != nullptr && !value->get().empty()) return &value->get();
  wrong(key, *node, "a string that is not empty");
  return nullptr;
}

void Section::text(std::string_view key, std::string& target, Need need) {
  const std::string* value = find_text(key, need);
  if (value == nullptr) return;
  // What stands behind the end of a line could be taken for a message of the program.
  if (one_line(*value) == *value) {
    target = *value;
  } else {
    wrong(key, *table_->get(key), "a string of one line, without control characters");
  }
}

void Section::lines(std::string_view key, std::string& target, Need need) {
  if (const std::string* value = find_text(key, need)) target = *value;
}

void Section::file_stem(std::string_view key, std::string& target) {
  constexpr std::string_view kExpected =
      "a name of at most 64 letters, digits, '.', '_' and '-' that starts with a letter or digit";
  const toml::node* node = find(key, kExpected, Need::required);
  if (node == nullptr) return;
  const auto* value = node->as_string();
  if (value != nullptr && is_file_stem(value->get())) {
    target = value->get();
  } else {
    wrong(key, *node, kExpected);
  }
}

std::optional<std::size_t> Section::one_of(std::string_view key, const std::vector<std::string_view>& names,
                                           Need need) {
  const std::string expected = quoted_list(names);
  const toml::node* node = find(key, expected, need);
  if (node == nullptr) return std::nullopt;
  if (const auto* value = node->as_string()) {
    const auto found = std::find(names.begin(), names.end(), value->get());
    if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  }
  wrong(key, *node, expected);
  return std::nullopt;
}

std::optional<Section> Section::section(std::string_view key, Need need) {
  const toml::node* node = find(key, "a table", need);
  if (node == nullptr) return std::nullopt;
  if (const toml::table* table = node->as_table()) return Section(*table, path(key), *document_);
  wrong(key, *node, "a table");
  return std::nullopt;
}

std::optional<Section> Section::section_or_none(std::string_view key) {
  constexpr std::string_view kExpected = "a table or \"none\"";
  const toml::node* node = find(key, kExpected, Need::required);
  if (node == nullptr) return std::nullopt;
  if (const toml::table* table = node->as_table()) return Section(*table, path(key), *document_);
  const auto* word = node->as_string();
  if (word == nullptr || word->get() != "none") wrong(key, *node, kExpected);
  return std::nullopt;
}

std::vector<Section> Section::sections(std::string_view key, Need need) {
  constexpr std::string_view kExpected = "an array of at least one table";
  std::vector<Section> result;
  const toml::node* node = find(key, kExpected, need);
  if (node == nullptr) return result;
  const toml::array* array = node->as_array();
  if (array == nullptr || array->empty()) {
    wrong(key, *node, kExpected);
    return result;
  }
  for (std::size_t i = 0; i < array->size(); ++i) {
    const toml::node& element = *array->get(i);
    const std::string element_path = fmt::format("{}[{}]", path(key), i);
    if (const toml::table* table = element.as_table()) {
      result.emplace_back(*table, element_path, *document_);
    } else {
      document_->issues.add(place(element.source()), element_path, "a table", shown(element));
    }
  }
  return result;
}

void Section::volts_file(std::string_view key, VoltsFile& target) {
  text(key, target.name);
  const std::string key_path = path(key);
  if (!has(key) || !document_->issues.clean(key_path) || document_->named_files == NamedFiles::leave) return;
  const Position position = document_->positions.at(key_path);
  if (document_->named_files == NamedFiles::refuse) {
    document_->issues.add_text(position, key_path,
                               fmt::format("\"{}\" is not sent with the experiment: the service receives the "
                                           "experiment's text only; play it with --local",
                                           shortened(target.name, 60)));
    return;
  }
  try {
    const auto folder = std::filesystem::path(document_->file_name).parent_path();
    target = read_volts_csv(folder / target.name, target.name);
  } catch (const Error& error) {
    document_->issues.add_text(position, key_path, error.what());
  }
}

void Section::add_issues(const std::vector<OptionIssue>& issues) {
  for (const OptionIssue& issue : issues) {
    const std::string key_path = path(issue.key);
    if (!document_->issues.clean(key_path)) continue;
    document_->issues.add_text(position_of(document_->positions, key_path), key_path, issue.message);
  }
}

void Section::forbid(std::string_view key, std::string_view why) {
  known_.push_back(key);
  if (const toml::node* node = table_->get(key)) {
    document_->issues.add(place(node->source()), path(key), fmt::format("no such key ({})", why), shown(*node));
  }
}

void Section::finish() {
  for (const auto& [key, node] : *table_) {
    const std::string_view name = key.str();
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
    if (std::find(millimetre_keys_.begin(), millimetre_keys_.end(), name) != millimetre_keys_.end()) continue;
    document_->issues.add(place(key.source()), path(shortened(name, 60)), "a known key" + suggestion(name, known_),
                          "an unknown one");
  }
}

}  // namespace eha::config
