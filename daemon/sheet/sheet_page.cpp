// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/shell_word.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/page.hpp"
#include "daemon/sheet/run_sheet.hpp"

namespace eha::sheet {
namespace {

using report::Column;

std::vector<double> scaled(const Eigen::VectorXd& values, double factor) {
  std::vector<double> list(values.begin(), values.end());
  for (double& value : list) value *= factor;
  return list;
}

/// The flow curve: the rod's speed over the command, and the lines through it.
report::Item flow_curve(const RunSheet& run, const DisplayUnit& unit) {
  const ident::ValveSheet& sheet = run.sheet;
  const double factor = unit.factor("in");
  const double upper_V = sheet.null_V.value + sheet.dead_band_V.value;
  const double lower_V = sheet.null_V.value - sheet.dead_band_V.value;
  const double highest_V = sheet.block_V.maxCoeff();
  const double lowest_V = sheet.block_V.minCoeff();
  plot::Panel panel{.x_label = "command [V]", .y_label = fmt::format("speed [{}/s]", unit.of("in"))};
  panel.series.push_back({.label = "measured, each over 0.2 s",
                          .x = scaled(sheet.block_V, 1.0),
                          .y = scaled(sheet.block_in_per_s, factor),
                          .mark = plot::Mark::points,
                          .style = 0});
  // What leaks adds to the valve's flow.
  const double creep = sheet.creep_in_per_s ? sheet.creep_in_per_s->value : 0.0;
  panel.series.push_back(
      {.label = "dead band, gains and drift",
       .x = {lowest_V, lower_V, upper_V, highest_V},
       .y = {factor * (creep - sheet.gain_negative_in_per_V_s.value * (lower_V - lowest_V)), factor * creep,
             factor * creep, factor * (creep + sheet.gain_positive_in_per_V_s.value * (highest_V - upper_V))},
       .mark = plot::Mark::line,
       .style = 1});
  panel.shades.push_back({lower_V, upper_V, "dead band"});
  panel.rules.push_back({.at = sheet.null_V.value, .vertical = true, .label = "null"});
  report::Item item{.heading = "Flow curve; the dead band is shaded, the null dashed"};
  item.figure = plot::Figure{.title = item.heading, .panels = {std::move(panel)}};
  const bool drifts = sheet.creep_in_per_s && std::abs(creep) > sheet.creep_in_per_s->half_width;
  item.remark.seen =
      drifts ? fmt::format(
                   "From {:.3f} to {:.3f} V the rod hardly moves: at {:.2g} {}/s, too slowly for a leak to repair.",
                   lower_V, upper_V, factor * creep, unit.of("in"))
             : fmt::format("The rod stands from {:.3f} to {:.3f} V.", lower_V, upper_V);
  item.remark.good = "Points on the line on both sides, except just after a reversal, while the pressures settle.";
  if (const auto leak = ident::leak_of(sheet)) {
    item.remark.seen = fmt::format(
        "The valve's dead band is from {:.3f} to {:.3f} V, but {}. The leak bends the points near the edges, where "
        "they lie beside the line.",
        lower_V, upper_V, ident::leak_text(*leak, unit));
    item.remark.good = "Points on the line on both sides, and at 0 within the dead band.";
    item.remark.to_do =
        "Repair the leak and measure again: no null makes this rod stand, and null and dead band are known the worse "
        "for it.";
    return item;
  }
  item.remark.to_do = sheet.has_hysteresis
                          ? "Rising and falling command differ: clean or dither the valve if a controller needs less."
                      : run.written || is_in_rig_file(run) || is_written_since(run)
                          ? "Nothing of the valve. Dry friction does not show here: the fit of a run names it."
                          : "Put the lines below into the rig file.";
  return item;
}

report::Item responses_of(const ident::ValveSheet& sheet) {
  plot::Panel gain{.x_label = "", .y_label = "gain [dB re lowest]", .log_x = true};
  plot::Panel phase{.x_label = "frequency [Hz]", .y_label = "phase [deg]", .log_x = true};
  int style = 1;
  for (const ident::AmplitudeResponse& response : sheet.responses) {
    if (response.points.empty()) continue;
    plot::Series gains{
        .label = fmt::format("{:g} %, 95 %", response.percent), .mark = plot::Mark::error_bars, .style = style};
    plot::Series phases{.label = "", .mark = plot::Mark::error_bars, .style = style};
    for (const ident::ResponsePoint& point : response.points) {
      gains.x.push_back(point.frequency_Hz);
      gains.y.push_back(point.gain_dB);
      gains.lower.push_back(point.gain_dB - point.gain_half_width_dB);
      gains.upper.push_back(point.gain_dB + point.gain_half_width_dB);
      phases.x.push_back(point.frequency_Hz);
      phases.y.push_back(point.phase_deg);
      phases.lower.push_back(point.phase_deg - point.phase_half_width_deg);
      phases.upper.push_back(point.phase_deg + point.phase_half_width_deg);
    }
    // A thin line joins the points of one amplitude.
    gain.series.push_back({.label = "", .x = gains.x, .y = gains.y, .style = plot::kGuideStyle});
    phase.series.push_back({.label = "", .x = phases.x, .y = phases.y, .style = plot::kGuideStyle});
    gain.series.push_back(std::move(gains));
    phase.series.push_back(std::move(phases));
    ++style;
  }
  report::Item item{.heading = "Speed over command, by amplitude in per cent of half the command range"};
  if (gain.series.empty()) {
    item.html = report::paragraph("No sine was measured: every one was beyond the limits or entered the dead band.");
    return item;
  }
  constexpr double kAir = 1.15;  // a bar at the edge would lie in the frame
  double lowest_Hz = std::numeric_limits<double>::infinity();
  double highest_Hz = 0.0;
  for (const ident::AmplitudeResponse& response : sheet.responses) {
    for (const ident::ResponsePoint& point : response.points) {
      lowest_Hz = std::min(lowest_Hz, point.frequency_Hz);
      highest_Hz = std::max(highest_Hz, point.frequency_Hz);
    }
  }
  gain.x_range = phase.x_range = std::pair(lowest_Hz / kAir, highest_Hz * kAir);
  gain.rules.push_back({.at = -3.0, .vertical = false});
  phase.rules.push_back({.at = -90.0, .vertical = false});
  item.figure = plot::Figure{.title = item.heading, .panels = {std::move(gain), std::move(phase)}};
  item.remark.seen = fmt::format(
      "Measured up to {:.2f} Hz; the slew limit ends it. The gain is relative to the lowest frequency of each "
      "amplitude, which is 0 dB; the phase is that of the speed over the command. Dashed, where an axis reaches so "
      "far: -3 dB and -90 deg.",
      highest_Hz);
  item.remark.good = "Curves of all amplitudes together, falling smoothly.";
  item.remark.to_do = "The response above the last frequency was not measured: do not rely on it.";
  return item;
}

/// The measured points; nothing without any.
std::optional<report::Item> response_table(const ident::ValveSheet& sheet) {
  std::vector<std::vector<std::string>> rows;
  for (const ident::AmplitudeResponse& response : sheet.responses) {
    for (const ident::ResponsePoint& p : response.points) {
      rows.push_back({fmt::format("{:g}", response.percent), fmt::format("{:.2f}", p.frequency_Hz),
                      fmt::format("{:.2f}", p.gain_dB), fmt::format("{:.2f}", p.gain_half_width_dB),
                      fmt::format("{:.1f}", p.phase_deg), fmt::format("{:.1f}", p.phase_half_width_deg)});
    }
  }
  if (rows.empty()) return std::nullopt;
  return report::Item{.heading = "Measured points",
                      .html = report::table({{"amplitude [%]", Column::number},
                                             {"frequency [Hz]", Column::number},
                                             {"gain [dB]", Column::number},
                                             {"± 95 %", Column::number},
                                             {"phase [deg]", Column::number},
                                             {"± 95 %", Column::number}},
                                            rows)};
}

/// What the sheet says in a word: a leak, the values that are not those of [following], or that all are.
std::string headline(const RunSheet& run, const std::vector<SheetRow>& rows) {
  if (ident::leak_of(run.sheet)) return "The rig leaks";
  if (!run.rig.limits.following) return "What was measured";
  std::vector<std::string> other;
  for (const SheetRow& row : rows) {
    if (!row.is_as_there) other.push_back(row.name);
  }
  if (other.empty()) return "The valve is as the rig file says";
  return fmt::format("Not as the rig file says: {}", fmt::join(other, ", "));
}

/// The quantities as a table, in a box.
std::string quantities(const RunSheet& run, const DisplayUnit& unit) {
  std::vector<std::vector<std::string>> rows;
  std::vector<report::TableColumn> columns{{"quantity"}, {"value, ± half a 95 % interval"}};
  if (run.rig.limits.following) columns.push_back({"by [following] as used, without its margins"});
  const std::vector<SheetRow> measured = sheet_rows(run, unit);
  for (const SheetRow& row : measured) {
    rows.push_back({row.name, row.value});
    if (columns.size() > 2)
      rows.back().push_back(row.in_rig_file + (row.is_as_there ? "" : ", outside the joint interval"));
  }
  const std::string warning = warning_of(run, unit);
  return fmt::format("<section class=\"verdict {}\"><h2>{}</h2>\n", warning.empty() ? "some" : "none",
                     headline(run, measured)) +
         (warning.empty() ? "" : report::paragraph("Warning: " + warning + ".")) + report::table(columns, rows) +
         report::paragraph(next_of(run, run.access)) + "</section>\n";
}

std::string preformatted(const std::string& text) { return "<pre>" + report::escaped(text) + "</pre>\n"; }

}  // namespace

std::string sheet_page(const RunSheet& run, const DisplayUnit& unit, std::vector<std::string>& missing) {
  const Origin origin = origin_of(run);
  const std::string lead =
      fmt::format("<p class=\"subtitle\">{}, {}; rig file {}, sha256 {}</p>\n", report::escaped(run.rig.name),
                  report::escaped(origin.run), report::escaped(origin.rig_file), origin.sha256) +
      quantities(run, unit);
  report::Section statics{.title = "Static"};
  statics.items.push_back(flow_curve(run, unit));
  report::Section dynamics{.title = "Dynamic"};
  dynamics.items.push_back(responses_of(run.sheet));
  if (auto points = response_table(run.sheet)) dynamics.items.push_back(std::move(*points));
  report::Section files{.title = "For the files"};
  files.items.push_back({.heading = "Rig file", .html = preformatted(rig_lines(run))});
  files.items.push_back({.heading = "Experiment file", .html = preformatted(experiment_lines(run))});
  report::Page page = report::assembled("Valve sheet", lead, {statics, dynamics, files}, run.access);
  missing = std::move(page.missing);
  return std::move(page.html);
}

}  // namespace eha::sheet
