// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/scope_facts.hpp"

#include <algorithm>
#include <map>
#include <string_view>

#include "daemon/importer/column_names.hpp"
#include "daemon/importer/csv_fields.hpp"

namespace eha::importer {
namespace {

using Fields = std::vector<std::string>;

/// More than any of these scopes writes about a channel.
constexpr std::size_t kMostFacts = 40;

std::string_view without_comment_sign(std::string_view line) {
  if (line.starts_with('#')) line.remove_prefix(1);
  return line;
}

Fields fields_of(std::string_view line, CsvFields& splitter) {
  Fields fields;
  if (!splitter.split(without_comment_sign(line))) return fields;
  for (std::size_t i = 0; i < splitter.size(); ++i) fields.emplace_back(splitter[i]);
  return fields;
}

bool begins_with(std::string_view line, std::string_view word) {
  line = without_comment_sign(line);
  return line.starts_with(word) && line.size() > word.size() &&
         (line[word.size()] == ',' || line[word.size()] == ';' || line[word.size()] == '\t');
}

std::string field_at(const Fields& fields, std::size_t i) { return i < fields.size() ? fields[i] : std::string(); }

}  // namespace

std::optional<std::size_t> scope_header_line(const std::vector<std::string>& lines) {
  bool has_interval = false;
  for (std::size_t k = 0; k < std::min(lines.size(), kMostFacts); ++k) {
    has_interval = has_interval || begins_with(lines[k], "Sample Interval");
    if (has_interval && begins_with(lines[k], "TIME")) return k;
  }
  return std::nullopt;
}

void take_facts_above(const std::vector<std::string>& lines, std::size_t header_line, Dialect& dialect) {
  CsvFields splitter(dialect.delimiter);
  const Fields header = fields_of(lines[header_line], splitter);
  dialect.names = header;
  dialect.names.resize(dialect.fields);
  dialect.units.assign(dialect.fields, "");
  dialect.header_line = header_line + 1;
  for (std::size_t k = 0; k < header_line; ++k) {
    const Fields facts = fields_of(lines[k], splitter);
    std::size_t block = 0;
    for (std::size_t i = 0; i < dialect.fields; ++i) {
      const bool is_time = field_at(header, i) == "TIME";
      if (is_time) block = i;
      const std::string fact = field_at(facts, block);
      if (is_time && fact == "Horizontal Units") dialect.units[i] = field_at(facts, i + 1);
      if (is_time || field_at(facts, i).empty()) continue;
      if (fact == "Vertical Units") dialect.units[i] = facts[i];
      if (fact == "Label") dialect.names[i] = facts[i];
    }
  }
}

bool take_facts_beside(const std::vector<std::string>& lines, Dialect& dialect) {
  CsvFields splitter(dialect.delimiter);
  if (lines.size() < 2) return false;
  const Fields first = fields_of(lines[0], splitter);
  const Fields second = fields_of(lines[1], splitter);
  std::vector<std::size_t> blocks;
  for (std::size_t i = 0; i < std::min(first.size(), second.size()); ++i) {
    if (first[i] == "Record Length" && second[i] == "Sample Interval") blocks.push_back(i);
  }
  if (blocks.empty()) return false;
  dialect.names.assign(dialect.fields, "");
  dialect.units.assign(dialect.fields, "");
  dialect.holds_facts.assign(dialect.fields, false);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    std::map<std::string, std::string> facts;
    for (std::size_t k = 0; k < std::min(lines.size(), kMostFacts); ++k) {
      const Fields fields = fields_of(lines[k], splitter);
      if (!field_at(fields, blocks[b]).empty()) facts[fields[blocks[b]]] = field_at(fields, blocks[b] + 1);
    }
    const std::size_t end = std::min(b + 1 < blocks.size() ? blocks[b + 1] : dialect.fields, dialect.fields);
    // Name and value of a fact, and perhaps an empty column.
    std::size_t time = blocks[b] + 2;
    while (time < end && field_at(first, time).empty()) ++time;
    for (std::size_t i = blocks[b]; i < end; ++i) {
      dialect.holds_facts[i] = i < time || field_at(first, i).empty();
      if (dialect.holds_facts[i]) continue;
      dialect.names[i] = i == time ? "time" : i == time + 1 ? facts["Source"] : "";
      dialect.units[i] = facts[i == time ? "Horizontal Units" : "Vertical Units"];
      if (i == time && dialect.units[i].empty()) dialect.units[i] = "s";
    }
  }
  return true;
}

}  // namespace eha::importer
