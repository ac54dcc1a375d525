// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/batch/batch_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/batch/table_text.hpp"
#include "daemon/report/figures.hpp"
#include "daemon/report/html.hpp"
#include "ident/model/parameter_text.hpp"

namespace eha::batch {
namespace {

constexpr std::size_t kMostNamed = 8;
constexpr std::size_t kMostNamedOnAxis = 16;

bool is_apart(const Row& row, const std::string& parameter) {
  return std::any_of(row.outliers.begin(), row.outliers.end(),
                     [&](const Outlier& o) { return o.parameter == parameter; });
}

void append(plot::Series& series, double x, double value, double lower, double upper) {
  series.x.push_back(x);
  series.y.push_back(value);
  series.lower.push_back(lower);
  series.upper.push_back(upper);
}

std::string some_of(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMostNamed); ++i) text += (i == 0 ? "" : ", ") + names[i];
  if (names.size() > kMostNamed) text += fmt::format(" and {} more", names.size() - kMostNamed);
  return text;
}

const Trend* trend_of(const Table& table, const std::string& parameter) {
  const auto found = std::find_if(table.trends.begin(), table.trends.end(),
                                  [&](const Trend& one) { return one.parameter == parameter; });
  return found == table.trends.end() ? nullptr : &*found;
}

/// How far the furthest record lies apart, in the distances from which on it does; 0: none does.
double furthest_outlier(const Table& table, const Parameter& parameter) {
  double furthest = 0.0;
  for (const Row& row : table.rows) {
    for (const Outlier& one : row.outliers) {
      if (one.parameter != parameter.name || !(one.half_width > 0.0)) continue;
      furthest = std::max(furthest, std::abs(one.value - one.median) / one.half_width);
    }
  }
  return furthest;
}

/// "K: gain", a parameter with what it is.
std::string meaning_of(const Table& table, const std::string& name) {
  if (name == "dead_band") return std::string(ident::kDeadBandIs);
  if (name == "null") return "null: the volts in the middle of the dead band";
  if (name == "negative_gain_ratio") return "negative_gain_ratio: gain of negative over that of positive volts";
  if (name == "K" && table.common_model.ends_with("_valve")) return "K: gain of positive volts, behind the dead band";
  if (name == "a2" && table.common_model.starts_with("integrator_lag")) return std::string(ident::kTimeConstantIs);
  return name;
}

/// Whether the records' values spread by far more than their own errors explain, as those of several plants do. A
/// record that lies apart in another parameter is another plant by that alone.
bool scatters(const Table& table, const Parameter& parameter) {
  constexpr double kBeyondErrors = 3.0;  // of the standard errors, root mean square
  double sum = 0.0;
  double count = 0.0;
  for (const Estimate& one : parameter.estimates) {
    if (!(one.std > 0.0)) return false;
    if (!table.rows[one.row].outliers.empty()) continue;
    sum += std::pow((one.value - parameter.median) / one.std, 2);
    count += 1.0;
  }
  return sum > kBeyondErrors * kBeyondErrors * count;
}

report::Item parameter_item(const Table& table, const Parameter& parameter) {
  plot::Series usual{.label = "", .mark = plot::Mark::error_bars, .style = 1};
  plot::Series apart{.label = "apart", .mark = plot::Mark::error_bars, .style = 2};
  std::vector<std::string> names;
  double lowest = parameter.estimates.front().value;
  double highest = lowest;
  for (const Estimate& one : parameter.estimates) {
    const Row& row = table.rows[one.row];
    const bool is_one = is_apart(row, parameter.name);
    const bool is_compared = one.half_width > 0.0;
    append(is_one ? apart : usual, static_cast<double>(one.row + 1), one.value,
           is_compared ? one.value - one.half_width : one.lower95,
           is_compared ? one.value + one.half_width : one.upper95);
    if (is_one) names.push_back(row.label);
    lowest = std::min(lowest, one.value);
    highest = std::max(highest, one.value);
  }
  plot::Panel panel{.x_label = "record, in the order of the list",
                    .y_label = report::axis_label({parameter.name, parameter.unit})};
  if (table.rows.size() <= kMostNamedOnAxis) {
    panel.x_label.clear();
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      panel.x_ticks.push_back({.at = static_cast<double>(i + 1), .text = table.rows[i].label});
    }
  }
  panel.x_range = std::pair(0.5, static_cast<double>(table.rows.size()) + 0.5);
  panel.rules = {{.at = parameter.median, .vertical = false}};
  panel.series.push_back(std::move(usual));
  if (!apart.x.empty()) panel.series.push_back(std::move(apart));
  report::Item item{.heading = meaning_of(table, parameter.name)};
  item.figure = plot::Figure{.title = fmt::format("{} over the records", parameter.name), .panels = {std::move(panel)}};
  const bool is_compared = parameter.estimates.size() >= kFewestForOutliers;
  const std::string unit = ident::after_number(parameter.unit);
  item.remark.seen =
      fmt::format("Median {:.5g}{} (the dashed line), from {:.5g} to {:.5g}{} over {} records, each with {}.",
                  parameter.median, unit, lowest, highest, unit, parameter.estimates.size(),
                  is_compared ? "the interval by which it is compared" : "its 95 % interval");
  const Trend* trend = trend_of(table, parameter.name);
  if (trend != nullptr) item.remark.seen += fmt::format(" It {} from the first to the last.", change_text(*trend));
  if (!is_compared) return item;  // the box says why
  item.remark.good = fmt::format(
      "Every interval holds the dashed line, without slope: the plant did not change. A record lies apart if its "
      "interval does not, which happens by chance in {:g} % of such tables; the interval holds its own error and the "
      "records' scatter.",
      100.0 * kOutlierLevel);
  item.remark.to_do =
      !names.empty() ? fmt::format("Look at what was different: {}.", some_of(names))
      : scatters(table, parameter)
          ? "No record lies apart from the others because they all scatter, beyond their own errors: plants or "
            "experiments differ. Compare the lowest with the highest by eha compare."
          : "Nothing: none of these records lies apart.";
  return item;
}

std::string names_apart(const Row& row) {
  std::string text;
  for (const Outlier& one : row.outliers) text += (text.empty() ? "" : ", ") + one.parameter;
  return text;
}

/// The name of a record's file or run; its whole path is in the provenance.
std::string shown_name(const Record& record) {
  const std::filesystem::path source = std::filesystem::path(record.source).lexically_normal();
  return (source.has_filename() ? source : source.parent_path()).filename().string();
}

std::string records_table(const Table& table) {
  const std::vector<NotCompared> left_out = not_compared(table.rows, table.common_model);
  std::vector<std::vector<std::string>> rows;
  for (const Row& row : table.rows) {
    if (!row.judged) continue;
    std::string missing = why_none(row);
    for (const NotCompared& one : left_out) {
      if (&table.rows[one.row] == &row && missing.empty()) {
        missing = (one.in_part ? "compared in part: " : "not compared: ") + one.reason;
      }
    }
    if (missing.empty()) missing = what_limits(row);
    RowFigures figures = row.figures;
    rows.push_back({row.label, shown_name(row.record), row.rig, row.recommended, grade_of(row),
                    std::move(figures.fit_percent), std::move(figures.error), std::move(figures.form), names_apart(row),
                    std::move(missing)});
  }
  using report::Column;
  std::vector<report::TableColumn> columns{{"record", Column::name},
                                           {"source", Column::name},
                                           {"rig", Column::name},
                                           {"recommended", Column::name},
                                           {"verdict"},
                                           {"fit on unseen data, %", Column::number},
                                           {"largest error", Column::number},
                                           {"in figures", Column::wide_text},
                                           {"apart in", Column::name},
                                           {"why no model, not good, or not compared", Column::wide_text}};
  constexpr std::size_t kRig = 2;
  if (std::all_of(rows.begin(), rows.end(), [](const auto& row) { return row[kRig].empty(); })) {  // files alone
    for (auto& row : rows) row.erase(row.begin() + kRig);
    columns.erase(columns.begin() + kRig);
  }
  return report::table(columns, rows);
}

std::string models_table(const Table& table) {
  std::map<std::pair<std::string, std::string>, std::size_t> counts;
  for (const Row& row : table.rows) {
    if (row.judged) ++counts[{row.recommended, grade_of(row)}];
  }
  std::vector<std::vector<std::string>> rows;
  for (const auto& [kind, count] : counts) rows.push_back({kind.first, kind.second, fmt::format("{}", count)});
  return report::table({{"recommended"}, {"verdict"}, {"records", report::Column::number}}, rows);
}

/// The model with the units of its parameters.
std::string compared_by(const Table& table) {
  for (const Row& row : table.rows) {
    if (!row.fit.is_object()) continue;
    for (const auto& model : row.fit.at("models")) {
      if (model.at("name") != table.common_model || !model.contains("units")) continue;
      const auto& units = model.at("units");
      return fmt::format("Compared by the model {}, with the units of the records: {}, {} and s.", table.common_model,
                         units.value("input", ""), units.value("output", ""));
    }
  }
  return fmt::format("Compared by the model {}.", table.common_model);
}

/// What the box says first: the worst that was found.
std::string heading_of(const Table& table, std::size_t failed, std::size_t apart, std::size_t left_out,
                       std::size_t warnings) {
  const auto records = [](std::size_t count, const char* one, const char* many) {
    return count == 1 ? fmt::format("1 record {}", one) : fmt::format("{} records {}", count, many);
  };
  if (table.judged == 0) return "No record is judged";
  if (apart > 0) return records(apart, "lies apart from the others", "lie apart from the others");
  if (!table.trends.empty())
    return fmt::format("{} {}", table.trends.front().parameter, change_text(table.trends.front()));
  if (failed > 0) return records(failed, "could not be judged", "could not be judged");
  if (table.missing > 0) return records(table.missing, "has no result yet", "have no result yet");
  if (left_out > 0) return records(left_out, "is not compared, or in part", "are not compared, or in part");
  if (table.resolutions.empty()) return "The records are judged; nothing is compared";
  const std::vector<Parameter> compared = parameters_of(table.rows, table.common_model);
  if (std::any_of(compared.begin(), compared.end(), [&](const Parameter& p) { return scatters(table, p); })) {
    return "No record lies apart from the others, as they scatter beyond their own errors";
  }
  return warnings > 0 ? "No record lies apart; there are warnings" : "No record lies apart from the others";
}

/// The box: the worst first, then what is asked of the reader, then what was done.
/// @param next  the command that goes on
std::string lead_of(const Table& table, std::size_t failed, const std::string& next) {
  std::vector<std::string> sentences;
  const bool is_compared = !table.resolutions.empty();
  std::size_t apart = 0;
  for (const Row& row : table.rows) {
    if (row.outliers.empty()) continue;
    if (++apart > kMostNamed) continue;
    for (const Outlier& one : row.outliers) {
      sentences.push_back(fmt::format("{} lies apart: {}.", row.label, outlier_text(one)));
    }
    if (const std::string instead = instead_text(row, table.common_model); !instead.empty()) {
      sentences.push_back(fmt::format("{}: {}.", row.label, instead));
    }
  }
  if (apart > kMostNamed) sentences.push_back(fmt::format("{} more lie apart, see the table.", apart - kMostNamed));
  for (const Trend& one : table.trends) {
    sentences.push_back(fmt::format("{} {} from the first record to the last.", one.parameter, change_text(one)));
  }
  if (failed > 0)
    sentences.push_back(fmt::format("{} could not be judged; the reasons are below the table of records.", failed));
  if (table.missing > 0) sentences.push_back(fmt::format("{} have no result yet.", table.missing));
  const std::vector<NotCompared> left_out =
      is_compared ? not_compared(table.rows, table.common_model) : std::vector<NotCompared>{};
  for (std::size_t i = 0; i < std::min(left_out.size(), kMostNamed); ++i) {
    sentences.push_back(fmt::format("{} is {}, so it may be the one that changed: {}.",
                                    table.rows[left_out[i].row].label,
                                    left_out[i].in_part ? "compared in part" : "not compared", left_out[i].reason));
  }
  if (left_out.size() > kMostNamed) {
    sentences.push_back(
        fmt::format("{} more are not compared, or in part, see the table.", left_out.size() - kMostNamed));
  }
  if (const std::string others = other_units_text(table); !others.empty()) {
    sentences.push_back(
        fmt::format("Not compared, as they are in other units: {}. Judge them in a batch of their own.", others));
  }
  const std::vector<WarningKind> warnings = warning_kinds(table);
  for (const WarningKind& one : warnings) sentences.push_back(fmt::format("Warned: {}", warning_text(table, one)));
  if (!is_compared) {
    sentences.push_back(
        fmt::format("Nothing was compared: that needs {} records with one model accepted; `eha compare` "
                    "compares two.",
                    kFewestForOutliers));
  } else if (apart == 0) {
    sentences.push_back(left_out.empty() ? "No record lies apart from the others."
                                         : "None of the compared records lies apart from the others.");
  }
  std::vector<std::string> to_do;
  if (failed > 0) to_do.emplace_back("mend what \"Not judged\" names, and judge those records in a new folder");
  if (table.missing > 0) to_do.emplace_back("give the same command again for the records without a result");
  if (!warnings.empty()) {
    to_do.emplace_back(
        "follow the warnings; a command's options for one record go behind -- for the whole batch, with "
        "a new folder (-o)");
  }
  if (apart > 0 || !table.trends.empty()) {
    to_do.emplace_back(
        "look at what was different where a record lies apart or a parameter moves, then `eha compare` "
        "that record with an ordinary one");
  }
  const auto is_in_part = [](const NotCompared& one) { return one.in_part; };
  if (!std::all_of(left_out.begin(), left_out.end(), is_in_part)) {
    to_do.emplace_back("cut or repeat the records that are not compared");
  }
  if (std::any_of(left_out.begin(), left_out.end(), is_in_part)) {
    to_do.emplace_back("`eha compare` a record that is compared in part with an ordinary one");
  }
  if (!is_compared && to_do.empty()) to_do.emplace_back("record more to compare, or use the models of each record");
  std::string asked =
      report::paragraph(to_do.empty() ? "To do: nothing." : fmt::format("To do: {}.", fmt::join(to_do, "; ")));
  // This page is open already.
  if (!next.empty() && !next.starts_with("xdg-open ")) asked += report::paragraph(fmt::format("Next: `{}`", next));
  std::vector<std::string> done;
  done.push_back(fmt::format("{} of {} {} judged.", table.judged, table.rows.size(),
                             table.rows.size() == 1 ? "record is" : "records are"));
  if (!table.common_model.empty() && is_compared) done.push_back(compared_by(table));
  for (const Resolution& one : table.resolutions) done.push_back(spread_text(table, one) + ".");
  const char* kind =
      warnings.empty() && apart == 0 && table.trends.empty() && failed == 0 && table.missing == 0 && left_out.empty()
          ? "all"
          : "some";
  return fmt::format("<section class=\"verdict {}\"><h2>{}</h2>\n", kind,
                     report::escaped(heading_of(table, failed, apart, left_out.size(), warnings.size()))) +
         report::list(sentences) + asked + report::list(done) + "</section>\n";
}

}  // namespace

report::Page page_of(const Table& table, const std::string& next) {
  const bool is_compared = !table.resolutions.empty();
  report::Section parameters{.title = fmt::format("Parameters of {} over the records", table.common_model)};
  report::Section others{.title = "Parameters in which no record lies apart", .folded = true};
  std::vector<Parameter> known = parameters_of(table.rows, table.common_model);
  std::stable_sort(known.begin(), known.end(), [&](const Parameter& a, const Parameter& b) {
    return furthest_outlier(table, a) > furthest_outlier(table, b);
  });
  for (const Parameter& parameter : known) {
    // One point shows no more than the table.
    if (parameter.estimates.size() < 2) continue;
    const bool moves = furthest_outlier(table, parameter) > 0.0 || trend_of(table, parameter.name) != nullptr ||
                       (is_compared && scatters(table, parameter));
    (!is_compared || moves ? parameters : others).items.push_back(parameter_item(table, parameter));
  }
  report::Section models{.title = "Recommended models"};
  report::Section records{.title = "Records"};
  if (table.judged > 0) {
    models.items.push_back({.heading = "", .html = models_table(table)});
    const std::string note = grade_note(table);
    records.items.push_back(
        {.heading = "", .html = records_table(table) + (note.empty() ? note : report::paragraph(note))});
  }
  std::vector<std::string> reasons;
  for (const Row& row : table.rows) {
    if (!row.judged) reasons.push_back(fmt::format("{}, {}: {}", row.label, shown_name(row.record), row.reason));
  }
  report::Section failures{.title = "Not judged"};
  if (!reasons.empty()) failures.items.push_back({.heading = "", .html = report::list(reasons)});
  std::vector<std::vector<std::string>> sources;
  for (const Row& row : table.rows) sources.push_back({row.label, row.record.id, row.record.source});
  report::Section provenance{.title = "Provenance", .folded = true};
  provenance.items.push_back({.heading = "",
                              .html = report::table({{"record", report::Column::name},
                                                     {"id in table.csv", report::Column::id},
                                                     {"file or run", report::Column::wide_text}},
                                                    sources)});
  const std::size_t failed = table.rows.size() - table.judged - table.missing;
  // What lies apart is the answer; else the records come first.
  const bool is_answer = is_compared && !parameters.items.empty();
  others.folded = is_answer;
  if (is_answer) {
    return report::assembled(fmt::format("{} records", table.rows.size()), lead_of(table, failed, next),
                             {parameters, records, failures, models, others, provenance});
  }
  return report::assembled(fmt::format("{} records", table.rows.size()), lead_of(table, failed, next),
                           {records, failures, models, parameters, others, provenance});
}

}  // namespace eha::batch
