// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/array_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "core/error.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/header_facts.hpp"

namespace eha::importer {
namespace {

constexpr int kDigitsOfDouble = 15;
constexpr int kDigitsOfSingle = 7;

/// Of "rec.in" or "rec/in" only the field may end in a unit; "X(:,2)" has none.
std::pair<std::string, std::string> name_and_unit_of_array(const std::string& label) {
  if (label.ends_with(')') || label.ends_with(']')) return {label, ""};
  const std::size_t separator = label.find_last_of("./");
  const std::size_t field = separator == std::string::npos ? 0 : separator + 1;
  auto [name, unit] = name_and_unit(std::string_view(label).substr(field));
  return {label.substr(0, field) + name, unit};
}

class ArrayTable final : public Table {
 public:
  ArrayTable(std::filesystem::path path, std::string guess, std::vector<ArrayColumn> arrays,
             std::optional<StatedPeriod> period)
      : path_(std::move(path)), guesses_{std::move(guess)}, arrays_(std::move(arrays)), period_(std::move(period)) {
    for (const ArrayColumn& array : arrays_) {
      Column column;
      column.label = array.name;
      std::tie(column.name, column.unit) = name_and_unit_of_array(array.name);
      if (!array.unit.empty()) column.unit = unit_of(array.unit);
      column.rows = array.values.size();
      const auto sampled = static_cast<std::ptrdiff_t>(std::min(kSampledRows, array.values.size()));
      column.sample.assign(array.values.begin(), array.values.begin() + sampled);
      columns_.push_back(std::move(column));
    }
  }

  [[nodiscard]] const std::vector<Column>& columns() const override { return columns_; }
  [[nodiscard]] const std::vector<std::string>& guesses() const override { return guesses_; }

  [[nodiscard]] std::string place() const override { return path_.string(); }
  [[nodiscard]] std::optional<StatedPeriod> stated_period() const override { return period_; }

  [[nodiscard]] std::optional<RowPeriod> period_of_rows(std::size_t column) override {
    constexpr double kDay_s = 86400.0;
    constexpr double kQuantum_s = 1e-5;  // of days in double precision
    RowClock clock;
    for (const double days : arrays_[column].values) clock.add(kDay_s * days, kQuantum_s);
    return clock.period();
  }

  [[nodiscard]] Rows read(const Selection& selection, const Progress& /*progress*/) override {
    Rows rows;
    rows.columns.resize(selection.columns.size());
    const std::size_t count = columns_.at(selection.columns.front()).rows;
    for (const std::size_t column : selection.columns) {
      if (columns_[column].rows == count) continue;
      throw DataError(fmt::format("{}: {} has {} values and {} has {}: columns of one record have equal lengths",
                                  path_.string(), columns_[selection.columns.front()].label, count,
                                  columns_[column].label, columns_[column].rows));
    }
    const ArrayColumn& first = arrays_[selection.columns.front()];
    rows.time_significant = first.is_single ? kDigitsOfSingle : kDigitsOfDouble;
    rows.time_decimals = kDigitsOfDouble;
    const auto time_of = [&](std::size_t k) {
      if (!selection.has_time) return static_cast<double>(k);
      const double at = first.values[k];
      return selection.time_unit_s < 1.0 ? at / std::round(1.0 / selection.time_unit_s) : at * selection.time_unit_s;
    };
    std::size_t asked = 0;
    for (std::size_t k = 0; k < count; ++k) asked += time_of(k) < selection.from || time_of(k) > selection.to ? 0U : 1U;
    if (asked > kMostRows) {
      throw DataError(fmt::format("{}: {} has {} rows, more than {}; read a part of them with --from and --to",
                                  path_.string(), columns_[selection.columns.front()].label, asked, kMostRows));
    }
    for (std::size_t k = 0; k < count; ++k) {
      const double at = time_of(k);
      if (at < selection.from || at > selection.to) continue;
      for (std::size_t i = 0; i < selection.columns.size(); ++i) {
        const double value = i == 0 && selection.has_time ? at : arrays_[selection.columns[i]].values[k];
        const bool may_lack = selection.keep_missing || i >= selection.may_lack_from;
        if (!std::isfinite(value) && !(may_lack && std::isnan(value))) {
          throw DataError(fmt::format("{}, row {}: {}: expected a finite number, got {}{}", path_.string(), k + 1,
                                      columns_[selection.columns[i]].label, value,
                                      selection.mend_missing.empty()
                                          ? ""
                                          : fmt::format("; `{}` fills missing values", selection.mend_missing)));
        }
        rows.columns[i].push_back(value);
      }
    }
    arrays_.clear();
    return rows;
  }

 private:
  std::filesystem::path path_;
  std::vector<std::string> guesses_;
  std::vector<ArrayColumn> arrays_;
  std::vector<Column> columns_;
  std::optional<StatedPeriod> period_;
};

/// The one number that a name such as Ts makes a sample period; none where two differ.
std::optional<Table::StatedPeriod> stated_period_of(const std::vector<ArrayColumn>& arrays) {
  constexpr double kSame = 1e-9;
  std::optional<Table::StatedPeriod> found;
  for (const ArrayColumn& array : arrays) {
    if (array.values.size() != 1) continue;
    const auto period_s = period_named(array.name.substr(array.name.find_last_of("./") + 1), array.values.front());
    if (!period_s) continue;
    if (found && std::abs(found->step_s - *period_s) > kSame * *period_s) return std::nullopt;
    found = {*period_s, array.name};
  }
  return found;
}

}  // namespace

std::unique_ptr<Table> table_of_arrays(const std::filesystem::path& path, Arrays arrays) {
  std::optional<Table::StatedPeriod> period = stated_period_of(arrays.columns);
  std::erase_if(arrays.columns, [](const ArrayColumn& a) { return a.values.size() < 2; });
  if (arrays.columns.empty()) {
    throw DataError(
        fmt::format("{}: a {} without arrays of numbers; {}", path.string(), arrays.guess,
                    arrays.remark.empty() ? "expected one array a column: time, input, output" : arrays.remark));
  }
  return std::make_unique<ArrayTable>(path, std::move(arrays.guess), std::move(arrays.columns), std::move(period));
}

bool can_hold(std::uint64_t file_bytes, std::uint64_t elements, std::uint64_t element_bytes) {
  constexpr std::uint64_t kMostExpansion = 1032;
  // In a division, which cannot overflow.
  return elements / kMostExpansion <= file_bytes / std::max<std::uint64_t>(element_bytes, 1) + 1;
}

}  // namespace eha::importer
