// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/study/study_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "daemon/report/html.hpp"

namespace eha::study {
namespace {

constexpr double kMostShown = 20.0;  // points of R2 to both sides of 0

/// Draws the treatments side by side, with a bar from the lower to the upper quartile around each median.
plot::Panel treatments_panel(const std::vector<Cell>& cells, std::size_t plant, const std::string& y_label,
                             Quartiles Cell::*value) {
  plot::Panel panel{.x_label = "", .y_label = y_label};
  plot::Series bars{.label = "", .mark = plot::Mark::error_bars, .style = 1};
  for (const Cell& cell : cells) {
    if (cell.plant != plant) continue;
    const double x = static_cast<double>(static_cast<std::size_t>(cell.treatment)) + 1.0;
    bars.x.push_back(x);
    bars.y.push_back((cell.*value).median);
    bars.lower.push_back((cell.*value).lower);
    bars.upper.push_back((cell.*value).upper);
    panel.x_ticks.push_back({.at = x, .text = std::string(title_of(cell.treatment))});
  }
  panel.x_range = std::pair(0.5, static_cast<double>(kTreatments.size()) + 0.5);
  panel.series.push_back(std::move(bars));
  return panel;
}

report::Item gain_item(const std::vector<Cell>& cells, std::size_t plant) {
  const PlantKind& kind = plant_kinds()[plant];
  plot::Panel panel = treatments_panel(cells, plant, "gain of FO over IO [points of R2]", &Cell::gain);
  double most = 1.0;
  for (const double end : panel.series.front().upper) most = std::max(most, end);
  for (const double end : panel.series.front().lower) most = std::max(most, -end);
  most = std::min(1.1 * most, kMostShown);
  panel.y_range = std::pair(-most, most);
  panel.rules = {{.at = 0.0, .vertical = false}};
  report::Item item{.heading = fmt::format("{}: what FO gains over IO", kind.title)};
  item.figure = plot::Figure{.title = item.heading, .panels = {std::move(panel)}};
  const auto published = std::find_if(cells.begin(), cells.end(), [&](const Cell& c) { return c.plant == plant; });
  const auto both = std::find_if(cells.begin(), cells.end(),
                                 [&](const Cell& c) { return c.plant == plant && c.treatment == Treatment::both; });
  if (published != cells.end() && both != cells.end()) {
    item.remark.seen = fmt::format(
        "Median gain {:+.2f} points by the paper's procedure and {:+.2f} by the default one, over {} records. {}",
        published->gain.median, both->gain.median, published->records, kind.what);
  }
  item.remark.good = kind.true_order && *kind.true_order < 2.0
                         ? "The gain stays when bias and history are included: FO is the right structure here."
                         : "No gain: this plant has no fractional order.";
  item.remark.to_do = "Judge a gain of FO by the default procedure, not by one that leaves out bias and history.";
  return item;
}

report::Item order_item(const std::vector<Cell>& cells, std::size_t plant) {
  const PlantKind& kind = plant_kinds()[plant];
  plot::Panel panel = treatments_panel(cells, plant, "highest order of FO", &Cell::fo_order);
  panel.rules = {{.at = *kind.true_order, .vertical = false}};
  report::Item item{.heading = fmt::format("{}: the order that FO finds", kind.title)};
  item.figure = plot::Figure{.title = item.heading, .panels = {std::move(panel)}};
  item.remark.seen = fmt::format("The dashed line is the plant's order, {:g}.", *kind.true_order);
  item.remark.good = "Short bars on the line.";
  item.remark.to_do = "Nothing: the plant is known here.";
  return item;
}

std::string cell_text(const Quartiles& q) {
  return fmt::format("{:.2f} ({:.2f} .. {:.2f})", q.median, q.lower, q.upper);
}

std::string table_of(const std::vector<Cell>& cells) {
  std::vector<std::vector<std::string>> rows;
  for (const Cell& cell : cells) {
    rows.push_back({std::string(plant_kinds()[cell.plant].title), std::string(title_of(cell.treatment)),
                    cell_text(cell.io_r2_percent), cell_text(cell.fo_r2_percent), cell_text(cell.gain),
                    fmt::format("{} of {}", cell.gains_as_printed, cell.records),
                    fmt::format("{} and {} of {}", cell.stable_io, cell.stable_fo, cell.records)});
  }
  using report::Column;
  return report::table({{"plant"},
                        {"treatment"},
                        {"R2 % of IO", Column::number},
                        {"R2 % of FO", Column::number},
                        {"gain, points", Column::number},
                        {fmt::format("gain of {:.2f} or more", kPrintedGain), Column::number},
                        {"stable IO, FO", Column::number}},
                       rows);
}

}  // namespace

report::Page page_of(const PaperStudy& study) {
  const std::vector<Cell> cells = cells_of(study);
  std::string lead = report::paragraph(fmt::format(
      "{} records of each kind of plant, each fitted by the paper's procedure and by the default one. R2 is on the "
      "half that estimated nothing; medians with quartiles. The paper printed 82.35 % for IO and 88.68 % for FO.",
      study.seeds));
  lead += "<section class=\"verdict some\"><h2>Conclusions</h2>\n" + report::list(conclusions(cells)) + "</section>\n";
  report::Section gains{.title = "What FO gains over IO"};
  report::Section orders{.title = "Orders"};
  report::Section failures{.title = "Records left out"};
  gains.items.push_back({.heading = "", .html = table_of(cells)});
  for (std::size_t plant = 0; plant < plant_kinds().size(); ++plant) {
    if (std::none_of(cells.begin(), cells.end(), [&](const Cell& c) { return c.plant == plant; })) continue;
    gains.items.push_back(gain_item(cells, plant));
    if (plant_kinds()[plant].true_order) orders.items.push_back(order_item(cells, plant));
  }
  std::vector<std::string> reasons;
  for (const StudyFailure& failure : study.failures) {
    reasons.push_back(fmt::format("{}, seed {}: {}", plant_kinds()[failure.plant].title, failure.seed, failure.reason));
  }
  if (!reasons.empty()) failures.items.push_back({.heading = "", .html = report::list(reasons)});
  return report::assembled("The paper's procedure and the default one", lead, {gains, orders, failures});
}

}  // namespace eha::study
