// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/header_rows.hpp"

#include <algorithm>
#include <cctype>
#include <optional>
#include <string_view>

#include "daemon/importer/clock_text.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/csv_fields.hpp"

namespace eha::importer {
namespace {

using Fields = std::vector<std::string>;

bool is_empty(const Fields& fields) {
  return std::all_of(fields.begin(), fields.end(), [](const std::string& field) { return field.empty(); });
}

bool is_number(const std::string& field) {
  double ignored = 0.0;
  return parse_number(field, {}, ignored) == NumberKind::finite ||
         parse_number(field, {.decimal = ','}, ignored) == NumberKind::finite;
}

bool is_name(const std::string& field) {
  const auto is_letter = [](unsigned char c) { return std::isalpha(c) != 0 || c >= 0x80; };
  return std::any_of(field.begin(), field.end(), is_letter) && !is_number(field) && !clock_seconds(field);
}

bool is_unit(const std::string& field) { return !field.empty() && may_be_unit(field); }

/// A unit each, or none where a column has none; dSPACE and others name the row in its first field: "unit,s,V,mm".
bool are_all_units(const Fields& fields) {
  if (std::none_of(fields.begin(), fields.end(), is_unit)) return false;
  const bool has_label = fields.front() == "unit" || fields.front() == "units";
  return std::all_of(fields.begin() + (has_label ? 1 : 0), fields.end(), may_be_unit);
}

/// Two units or more, and no more fields with anything else: "Einheit:,s,V,mm".
bool are_mostly_units(const Fields& fields) {
  const auto known = std::count_if(fields.begin(), fields.end(),
                                   [](const std::string& field) { return known_unit(field).has_value(); });
  const auto other = std::count_if(fields.begin(), fields.end(), [](const std::string& f) { return !may_be_unit(f); });
  return known >= 2 && other <= known;
}

class HeaderFinder {
 public:
  HeaderFinder(const Reading& reading, std::size_t first, std::size_t width) : lines_(reading.lines), width_(width) {
    // Delimiters alone separate a header from its rows in some programs' files.
    begin_ = first;
    // dSPACE writes a line of one word there, "trace_values".
    bool is_below_word = false;
    while (begin_ > 0 && (is_empty(lines_[begin_ - 1].fields) || is_lone_word(lines_[begin_ - 1].fields))) {
      --begin_;
      is_below_word = is_below_word || is_lone_word(lines_[begin_].fields);
    }
    // Its rows of names and units then begin with a word that the rows of numbers lack: "path", "unit".
    if (is_below_word && begin_ > 0) {
      const Fields& above = lines_[begin_ - 1].fields;
      has_labels_ = above.size() == width_ + 1 && !above.back().empty() && is_name(above.front());
    }
    const Fields& row = lines_[first].fields;
    is_first_column_empty_ = row.size() > 1 && row.front().empty();
  }

  [[nodiscard]] Header found() const {
    Header header;
    if (!take_names_and_units(header)) take_names(header);
    header.names.resize(std::min(header.names.size(), width_));
    header.units.resize(std::min(header.units.size(), width_));
    return header;
  }

 private:
  [[nodiscard]] bool is_lone_word(const Fields& fields) const {
    return width_ > 1 && !fields.empty() && is_name(fields.front()) &&
           std::all_of(fields.begin() + 1, fields.end(), [](const std::string& f) { return f.empty(); });
  }
  /// Rows end with a delimiter in some files, and in LabVIEW's lack the comment that the header names.
  [[nodiscard]] bool suits(const Fields& fields) const {
    if (has_labels_) return fields.size() == width_ + 1;
    return fields.size() == width_ ||
           (fields.size() == width_ + 1 && (fields.back().empty() || fields.back() == "Comment"));
  }
  /// The names of R's write.table lack one for the row numbers.
  [[nodiscard]] bool lacks_first(const Fields& fields) const { return fields.size() + 1 == width_; }
  [[nodiscard]] Fields without_label(Fields fields) const {
    if (has_labels_ && !fields.empty()) fields.erase(fields.begin());
    return fields;
  }

  [[nodiscard]] bool take_names_and_units(Header& header) const {
    for (std::size_t i = begin_; i-- > 1;) {
      const Fields& units = lines_[i].fields;
      const bool are_all = are_all_units(units);
      const bool lacks_one = lacks_first(units) && i + 1 == begin_ && are_all;
      if (!suits(units) && !lacks_one) return false;
      if (!are_all && !are_mostly_units(units)) continue;
      for (std::size_t j = i; j-- > 0;) {
        const Fields& names = lines_[j].fields;
        // Names of channels may be numbers: "x-axis,1,2" above "second,Volt,Volt".
        const bool is_beside = are_all && j + 1 == i && !are_all_units(names) && !is_empty(names);
        if (!(lacks_one ? lacks_first(names) : suits(names))) break;
        if (!is_beside && !are_names(names)) continue;
        set_names(header, are_repeated(j) ? begin_ - 1 : j);
        header.units = without_label(units);
        if (lacks_one) header.units.insert(header.units.begin(), "");
        for (std::string& unit : header.units) {
          if (!may_be_unit(unit)) unit.clear();
        }
        return true;
      }
    }
    return false;
  }

  /// Whether names of a preamble stand again right above the rows, there with that of the times: "Source,CH1,CH2",
  /// "Vertical Units,V,V", "Time,CH1,CH2".
  [[nodiscard]] bool are_repeated(std::size_t at) const {
    const Fields& names = lines_[at].fields;
    const Fields& above = lines_[begin_ - 1].fields;
    return at + 1 < begin_ && names.size() > 1 && above.size() == names.size() && are_names(above) &&
           std::equal(names.begin() + 1, names.end(), above.begin() + 1);
  }

  void take_names(Header& header) const {
    header.skipped_lines = begin_;
    if (begin_ == 0) return;
    const Fields& above = lines_[begin_ - 1].fields;
    if (!suits(above) && !lacks_first(above)) return;
    set_names(header, begin_ - 1);
    if (std::any_of(above.begin(), above.end(), is_name)) return;
    for (std::size_t i = begin_ - 1; i-- > 0 && suits(lines_[i].fields);) {
      if (are_names(lines_[i].fields)) return set_names(header, i);
    }
  }

  void set_names(Header& header, std::size_t at) const {
    header.names = without_label(lines_[at].fields);
    header.line = lines_[at].number;
    header.skipped_lines = at;
    if (lacks_first(header.names)) header.names.insert(header.names.begin(), "");
    // The first field names the row where the rows have nothing there.
    if (is_first_column_empty_) header.names.front().clear();
  }

  const std::vector<Line>& lines_;
  std::size_t width_;
  std::size_t begin_ = 0;
  bool is_first_column_empty_ = false;
  bool has_labels_ = false;  ///< names and units begin with a word of their own
};

/// Units of LabVIEW's second header.
void take_labview_units(const Reading& reading, std::size_t width, const std::vector<std::string>& all_lines,
                        Header& header) {
  const auto labels = std::find_if(all_lines.begin(), all_lines.end(),
                                   [](const std::string& line) { return line.starts_with("Y_Unit_Label"); });
  CsvFields splitter(reading.delimiter);
  if (!header.units.empty() || labels == all_lines.end() || !splitter.split(*labels)) return;
  header.units.assign(width, "");
  for (std::size_t i = 1; i < std::min(width, splitter.size()); ++i) header.units[i] = splitter[i];
}

}  // namespace

bool are_names(const std::vector<std::string>& fields) {
  return std::any_of(fields.begin(), fields.end(), is_name) && std::none_of(fields.begin(), fields.end(), is_number);
}

Header header_above(const Reading& reading, std::size_t first, std::size_t width,
                    const std::vector<std::string>& all_lines) {
  Header header = HeaderFinder(reading, first, width).found();
  take_labview_units(reading, width, all_lines, header);
  return header;
}

}  // namespace eha::importer
