// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/published/published_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "daemon/plot/envelope.hpp"
#include "daemon/published/published_summary.hpp"
#include "daemon/report/html.hpp"

namespace eha::published {
namespace {

plot::Series curve(const std::string& label, const Eigen::VectorXd& time_s, const Eigen::VectorXd& values, int style) {
  const auto span_of = [](const Eigen::VectorXd& v) { return std::span(v.data(), static_cast<std::size_t>(v.size())); };
  plot::Points points = plot::envelope(span_of(time_s), span_of(values));
  return {.label = label, .x = std::move(points.x), .y = std::move(points.y), .style = style};
}

std::string table_of(const std::vector<Line>& lines, const Test& test) {
  std::vector<std::vector<std::string>> rows;
  for (const Line& line : lines) {
    rows.push_back({fmt::format("{:.4g}", line.value), line.method, line.is_ours ? "this program" : line.source});
  }
  using report::Column;
  const std::string unit = test.unit.empty() ? "" : fmt::format(" [{}]", test.unit);
  return report::table({{std::string(test.measure.name) + unit, Column::number}, {"method"}, {"source"}}, rows);
}

report::Item item_of(const StudiedSet& studied, const ScoredTest& scored) {
  const Test& test = *scored.test;
  report::Item item{.heading = std::string(test.name)};
  plot::Panel outputs{.x_label = "", .y_label = "output"};
  outputs.series = {curve("measured", scored.time_s, scored.measured, 0),
                    curve(studied.model->name, scored.time_s, scored.simulated, 1)};
  plot::Panel error{.x_label = "time [s]", .y_label = "error"};
  error.series = {curve("", scored.time_s, scored.measured - scored.simulated, 1)};
  error.rules = {{.at = 0.0, .vertical = false}};
  item.figure = plot::Figure{.title = fmt::format("{}, {}", studied.set->title, test.name),
                             .panels = {std::move(outputs), std::move(error)}};
  item.remark.seen = fmt::format("{:.4g} {}: {}.", scored.score, test.unit, heading(scored));
  item.remark.good = "An error like noise, small beside the output.";
  item.remark.to_do =
      "Nothing: the records are those of others. Where the error follows the input, a structure is missing.";
  item.html = table_of(ranked(studied, scored), test);
  return item;
}

report::Section section_of(const StudiedSet& studied) {
  report::Section section{.title = std::string(studied.set->title)};
  report::Item first;
  first.html = report::paragraph(studied.set->what);
  if (studied.model) first.html += report::paragraph(model_line(studied)) + report::equation(*studied.model);
  if (!studied.recommendation.empty()) first.html += report::paragraph(studied.recommendation);
  if (!studied.failure.empty()) first.html += report::paragraph("No score: " + studied.failure);
  section.items.push_back(std::move(first));
  for (const ScoredTest& scored : studied.tests) section.items.push_back(item_of(studied, scored));
  return section;
}

}  // namespace

report::Page page_of(const std::vector<StudiedSet>& study) {
  const auto there = std::count_if(study.begin(), study.end(), [](const StudiedSet& s) { return !s.is_absent(); });
  const std::string lead = report::paragraph(fmt::format(
      "{} of {} published sets. For each the ladder is climbed on the estimating part, and the recommended model is "
      "simulated over the test in free run. Nothing is chosen by the test.",
      there, study.size()));
  std::vector<report::Section> sections;
  std::vector<std::string> absent;
  for (const StudiedSet& studied : study) {
    if (studied.is_absent()) {
      absent.push_back(fmt::format("{}: {}", studied.set->title, absence(studied)));
    } else {
      sections.push_back(section_of(studied));
    }
  }
  if (!absent.empty()) {
    report::Item item{.heading = ""};
    item.html = report::list(absent);
    sections.push_back({.title = "Sets that are not there", .items = {std::move(item)}});
  }
  return report::assembled("Published records", lead, sections);
}

}  // namespace eha::published
