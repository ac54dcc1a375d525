// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/sheet/compared_sheets.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "daemon/report/html.hpp"
#include "ident/model/difference_text.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/statistics/distributions.hpp"
#include "ident/validation/parameter_change.hpp"

namespace eha::sheet {
namespace {

using ident::Measured;

constexpr const char* kNoiseName = "sensor's noise at rest, rms";
constexpr double kNoiseShare = 0.2;  // of the noise, its half width: a sheet does not tell from how many rows it is

Measured scaled(const Measured& measured, double factor) {
  return {factor * measured.value, factor * measured.half_width};
}

/// Null and dead band are measured by the same edges: their errors are taken as independent.
Measured edge(const ident::ValveSheet& sheet, double side) {
  return {sheet.null_V.value + side * sheet.dead_band_V.value,
          std::hypot(sheet.null_V.half_width, sheet.dead_band_V.half_width)};
}

std::vector<ComparedQuantity> quantities_of(const ident::ValveSheet& a, const ident::ValveSheet& b,
                                            const DisplayUnit& unit) {
  const double factor = unit.factor("in");
  const std::string gain_unit = unit.of("in") + "/(V s)";
  std::vector<ComparedQuantity> all{{"null", "V", a.null_V, b.null_V},
                                    {"upper edge of the dead band", "V", edge(a, 1.0), edge(b, 1.0)},
                                    {"lower edge of the dead band", "V", edge(a, -1.0), edge(b, -1.0)},
                                    {"gain extending", gain_unit, scaled(a.gain_positive_in_per_V_s, factor),
                                     scaled(b.gain_positive_in_per_V_s, factor)},
                                    {"gain retracting", gain_unit, scaled(a.gain_negative_in_per_V_s, factor),
                                     scaled(b.gain_negative_in_per_V_s, factor)}};
  if (a.creep_in_per_s && b.creep_in_per_s) {
    all.push_back({"drift inside the dead band", unit.of("in") + "/s", scaled(*a.creep_in_per_s, factor),
                   scaled(*b.creep_in_per_s, factor)});
  }
  const auto noise = [&](double noise_in) { return Measured{factor * noise_in, kNoiseShare * factor * noise_in}; };
  all.push_back({kNoiseName, unit.of("in"), noise(a.noise_in), noise(b.noise_in)});
  return all;
}

void set_joint_intervals(std::vector<std::vector<ComparedQuantity>>& sheets) {
  std::size_t all = 0;
  for (const auto& quantities : sheets) all += quantities.size();
  const double standard_errors =
      ident::normal_exceeded(ident::kFalseAlarm / (2.0 * static_cast<double>(std::max<std::size_t>(1, all))));
  for (auto& quantities : sheets) {
    for (ComparedQuantity& one : quantities) {
      one.joint = standard_errors / ident::kInterval95 * std::hypot(one.before.half_width, one.after.half_width);
    }
  }
}

}  // namespace

bool ComparedQuantity::changed() const { return std::abs(after.value - before.value) > joint; }

ComparedSheets compare_sheets(const std::vector<RunSheet>& sheets, const DisplayUnit& unit) {
  ComparedSheets compared;
  const bool are_of_one_rig = std::all_of(sheets.begin(), sheets.end(),
                                          [&](const RunSheet& run) { return run.rig.name == sheets.front().rig.name; });
  for (const RunSheet& run : sheets) {
    const bool is_first = &run == &sheets.front();
    compared.names.push_back(fmt::format("{} on {}", run.folder.string(), run.rig.name));
    compared.sentences.push_back(fmt::format("{}: {}.", is_first ? "Before" : "After", compared.names.back()));
    if (is_first) continue;
    compared.quantities.push_back(quantities_of(sheets.front().sheet, run.sheet, unit));
    if (run.rig.name != sheets.front().rig.name) {
      compared.sentences.push_back("The sheets are of two rigs: a difference is no change of either.");
    }
  }
  set_joint_intervals(compared.quantities);
  std::vector<std::string> changed;
  const auto leak = ident::leak_of(sheets.back().sheet);
  compared.measured_again = sheets.size() - 1;
  for (std::size_t i = 0; i < compared.quantities.size(); ++i) {
    for (const ComparedQuantity& one : compared.quantities[i]) {
      const bool is_named = std::find(changed.begin(), changed.end(), one.name) != changed.end();
      if (one.changed() && !leak) compared.measured_again = i + 1;
      if (one.changed() && !is_named) changed.push_back(one.name);
    }
  }
  compared.rig = sheets[compared.measured_again].access;
  if (changed.empty()) {
    compared.heading = are_of_one_rig ? "The sheets show no change" : "The sheets show no difference of the rigs";
  } else {
    compared.heading = fmt::format("{}: {}", are_of_one_rig ? "The sheet has changed" : "The sheets of the rigs differ",
                                   fmt::join(changed, ", "));
  }
  if (leak) {
    compared.sentences.push_back(ident::leak_finding(*leak, unit));
  } else if (changed == std::vector<std::string>{kNoiseName}) {
    compared.sentences.emplace_back("The noise is the sensor's, not the valve's: look at sensor, wire and shield.");
  } else if (!changed.empty() && are_of_one_rig) {
    compared.sentences.emplace_back(
        "A null moves with the oil's temperature, a gain with the load, with dry friction and with the square root of "
        "what drops over the valve: look at these before you blame the valve. `eha characterise` measures it again.");
  }
  compared.sentences.push_back(
      fmt::format("At most {:g} % false alarms for all quantities and sheets together.", 100.0 * ident::kFalseAlarm));
  return compared;
}

std::vector<std::vector<std::string>> rows_of(const std::vector<ComparedQuantity>& quantities) {
  std::vector<std::vector<std::string>> rows;
  for (const ComparedQuantity& one : quantities) {
    const ident::DifferenceText text = ident::difference_text(one.after.value - one.before.value, one.joint);
    rows.push_back({one.name, ident::with_half_width(one.before.value, one.before.half_width, "+-"),
                    ident::with_half_width(one.after.value, one.after.half_width, "+-"), text.difference,
                    text.half_width, one.unit, one.changed() ? "yes" : "not shown"});
  }
  return rows;
}

nlohmann::ordered_json to_json(const ComparedSheets& compared) {
  nlohmann::ordered_json sheets = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < compared.quantities.size(); ++i) {
    nlohmann::ordered_json quantities = nlohmann::ordered_json::array();
    for (const ComparedQuantity& one : compared.quantities[i]) {
      quantities.push_back({{"name", one.name},
                            {"unit", one.unit},
                            {"before", one.before.value},
                            {"after", one.after.value},
                            {"joint_half_width", one.joint},
                            {"changed", one.changed()}});
    }
    sheets.push_back({{"source", compared.names[i + 1]}, {"quantities", std::move(quantities)}});
  }
  return {{"schema", "eha-sheet-comparison/1"},
          {"first", compared.names.front()},
          {"false_alarm", ident::kFalseAlarm},
          {"sheets", std::move(sheets)}};
}

report::Page page_of(const ComparedSheets& compared) {
  std::string lead = fmt::format("<section class=\"verdict some\"><h2>{}</h2>\n{}</section>\n",
                                 report::escaped(compared.heading), report::list(compared.sentences));
  report::Section section{.title = "Valve sheets"};
  for (std::size_t i = 0; i < compared.quantities.size(); ++i) {
    section.items.push_back({.heading = compared.names[i + 1],
                             .html = report::table({{"quantity"},
                                                    {"before", report::Column::number},
                                                    {"after", report::Column::number},
                                                    {"difference", report::Column::number},
                                                    {"joint ±", report::Column::number},
                                                    {"unit"},
                                                    {"changed"}},
                                                   rows_of(compared.quantities[i]))});
  }
  return report::assembled("Comparison of valve sheets", lead, {section}, compared.rig);
}

}  // namespace eha::sheet
