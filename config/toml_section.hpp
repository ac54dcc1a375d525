// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <toml++/toml.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "config/issue_list.hpp"
#include "config/named_files.hpp"
#include "config/position.hpp"
#include "core/keys.hpp"
#include "core/millimetre_key.hpp"
#include "core/option_issue.hpp"
#include "core/volts_file.hpp"

namespace eha::config {

/// A parsed file while it is read.
struct Document {
  toml::table root;
  IssueList issues;
  PositionMap positions;
  std::string file_name;
  NamedFiles named_files = NamedFiles::refuse;
};

/// Adds a fault of the key at `path`, with its place in the file.
void add_fault(Document& document, const std::string& path, std::string_view expected, std::string_view got);

/// @throws ConfigError  not TOML, with the place of the syntax error, or binary, or empty
[[nodiscard]] Document parse_document(std::string_view text, const std::string& file_name,
                                      NamedFiles named_files = NamedFiles::refuse);

/// One table of a file, read key by key. A key that is missing, of the wrong type or out of range adds an issue to the
/// document and leaves its target unchanged. finish() then reports every key that was never read.
class Section {
 public:
  Section(const toml::table& table, std::string path, Document& document);
  static Section root(Document& document) { return {document.root, "", document}; }

  [[nodiscard]] bool has(std::string_view key) const { return table_->contains(key); }
  /// Full path of a key.
  [[nodiscard]] std::string path(std::string_view key) const;

  /// A key in inches may be given in millimetres instead, see core/millimetre_key.hpp; `target` and `range` are in
  /// inches.
  void number(std::string_view key, double& target, const Range& range, Need need = Need::required);
  void boolean(std::string_view key, bool& target, Need need = Need::required);
  /// A string of one line that is not empty.
  void text(std::string_view key, std::string& target, Need need = Need::required);
  /// A string with a sentence a line; in no message.
  void lines(std::string_view key, std::string& target, Need need = Need::required);
  /// A string of at most 64 letters, digits, '.', '_' and '-' that starts with a letter or digit.
  void file_stem(std::string_view key, std::string& target);

  template <typename Integer>
  void integer(std::string_view key, Integer& target, std::int64_t low, std::int64_t high, Need need = Need::required) {
    static_assert(std::is_integral_v<Integer>);
    if (const auto value = whole_number(key, low, high, need)) target = static_cast<Integer>(*value);
  }

  /// The same for an optional key without a default.
  template <typename Integer>
  void integer(std::string_view key, std::optional<Integer>& target, std::int64_t low, std::int64_t high) {
    if (const auto value = whole_number(key, low, high, Need::optional)) target = static_cast<Integer>(*value);
  }
  void number(std::string_view key, std::optional<double>& target, const Range& range);
  void boolean(std::string_view key, std::optional<bool>& target);
  /// A required number, or the word "unknown", which leaves the target empty.
  void number_or_unknown(std::string_view key, std::optional<double>& target);

  /// One of the names in `choices`, a list of {name, value}.
  template <typename Choices, typename Value>
  void choice(std::string_view key, Value& target, const Choices& choices, Need need = Need::required) {
    std::vector<std::string_view> names;
    for (const auto& choice : choices) names.push_back(choice.first);
    if (const auto index = one_of(key, names, need)) target = choices[*index].second;
  }

  /// A table beneath this one.
  [[nodiscard]] std::optional<Section> section(std::string_view key, Need need = Need::required);
  /// A table beneath this one, or the word "none".
  [[nodiscard]] std::optional<Section> section_or_none(std::string_view key);
  /// An array of tables; an issue if it is required and has none.
  [[nodiscard]] std::vector<Section> sections(std::string_view key, Need need = Need::required);

  /// A table that lists its own keys, see core/keys.hpp.
  template <typename Table>
  void table(std::string_view key, Table& target, Need need = Need::required) {
    table_of<Table>(key, target, need);
  }
  /// The same for a table whose keys are listed by `Keys`.
  template <typename Keys, typename Table>
  void table_of(std::string_view key, Table& target, Need need = Need::required) {
    if (auto inner = section(key, need)) {
      Keys::visit_keys(target, *inner);
      inner->finish();
    }
  }
  template <typename Table>
  void optional_table(std::string_view key, std::optional<Table>& target) {
    if (auto inner = section(key, Need::optional)) inner->keys_of(target.emplace());
  }
  template <typename Table>
  void table_or_none(std::string_view key, std::optional<Table>& target) {
    if (auto inner = section_or_none(key)) inner->keys_of(target.emplace());
  }
  template <typename Table>
  void tables(std::string_view key, std::vector<Table>& target) {
    for (Section& inner : sections(key)) inner.keys_of(target.emplace_back());
  }

  /// Reads a CSV file of volts by its name, relative to the folder of the configuration file.
  void volts_file(std::string_view key, VoltsFile& target);

  /// Reports issues of this table's values, except of values that could not be read.
  void add_issues(const std::vector<OptionIssue>& issues);

  /// Reports a key that is not allowed here, with the reason.
  void forbid(std::string_view key, std::string_view why);

  /// Accepts a key without reading it.
  void ignore(std::string_view key) { known_.push_back(key); }

  /// Reports every key that was not read, with the nearest known one.
  void finish();

 private:
  template <typename Table>
  void keys_of(Table& target) {
    Table::visit_keys(target, *this);
    finish();
  }
  void number_in_millimetres(std::string_view key, const MillimetreKey& written, const toml::node& node, double& target,
                             const Range& range);
  const toml::node* find(std::string_view key, std::string_view expected, Need need);
  const std::string* find_text(std::string_view key, Need need);
  std::optional<std::int64_t> whole_number(std::string_view key, std::int64_t low, std::int64_t high, Need need);
  std::optional<std::size_t> one_of(std::string_view key, const std::vector<std::string_view>& names, Need need);
  void wrong(std::string_view key, const toml::node& node, std::string_view expected);

  const toml::table* table_;
  std::string path_;
  Document* document_;
  std::vector<std::string_view> known_;
  std::vector<std::string> millimetre_keys_;  ///< known, too
};

}  // namespace eha::config
