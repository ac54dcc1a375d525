// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/capitalised.hpp"
#include "daemon/report/advice.hpp"
#include "daemon/report/figures.hpp"
#include "daemon/report/section.hpp"
#include "daemon/report/sheet_comparison.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/signal/valve_map.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::report {
namespace {

constexpr double kRareSide_percent = 15.0;  // fewer samples on a side of the dead band determine the map poorly

/// Whether the record shows a dead band: its interval lies above 0.
bool has_dead_band(const ident::Model& model) {
  for (const ident::ParameterEstimate& p : model.parameters) {
    if (p.role == ident::ParameterRole::dead_band) return p.fixed || p.lower95 > 0.0;
  }
  return model.input_map->dead_band > 0.0;
}

/// A value with the decimals that the interval of a parameter justifies, as the table of parameters has that one.
std::string rounded_as(const ident::Model& model, ident::ParameterRole role, double value) {
  for (const ident::ParameterEstimate& p : model.parameters) {
    if (p.role == role) return ident::rounded_to(value, ident::half_width95(p));
  }
  return ident::rounded_to(value, 0.0);
}

Remark remark_on_valve(const Subject& subject, const ident::Model& model) {
  if (!has_dead_band(model)) {
    return {.seen = "The record shows no dead band: its interval holds 0.",
            .good = "For a valve: a dead band that is known, or none.",
            .to_do = "As the box above says."};
  }
  const std::vector<double>& input = subject.fit.applied;
  const ident::ValveMap& map = *model.input_map;
  const double low = map.null - map.dead_band;
  const double high = map.null + map.dead_band;
  const std::string& unit = model.input_unit;
  using Role = ident::ParameterRole;
  const auto rounded = [&](double value, Role role) { return rounded_as(model, role, value); };
  Remark remark;
  remark.seen =
      fmt::format("The valve passes nothing from {} to {} {}; below, it passes {} times as much per {} as above.",
                  rounded(low, Role::dead_band), rounded(high, Role::dead_band), unit,
                  rounded(map.negative_gain_ratio, Role::negative_gain_ratio), unit);
  double rarer_percent = 100.0;
  if (!input.empty()) {
    const auto share = [&](auto test) {
      return 100.0 * static_cast<double>(std::count_if(input.begin(), input.end(), test)) /
             static_cast<double>(input.size());
    };
    const double above = share([&](double u) { return u > high; });
    const double below = share([&](double u) { return u < low; });
    rarer_percent = std::min(above, below);
    remark.seen += fmt::format(" {:.0f} % of the samples lie above the dead band, {:.0f} % below.", above, below);
  }
  remark.good =
      fmt::format("At least {:.0f} % of the samples on either side, and narrow intervals of null and dead band.",
                  kRareSide_percent);
  const std::optional<double> shift = ident::noted_shift(model);
  const bool misses = model.verdict && may_miss_a_part(*model.verdict);
  if (rarer_percent < kRareSide_percent) {
    remark.to_do = "The input was rarely on one side of the dead band: record with an offset_V near the null.";
  } else if (shift) {
    remark.to_do =
        "Compensate nothing by these numbers: for a controller take null and dead band of the valve sheet (`eha "
        "characterise`), or of [following] in the rig file where it is from a sheet; eha tune takes them with its "
        "option --sheet.";
  } else if (misses) {
    remark.to_do =
        "What the model may miss, as friction or a leak, shifts these numbers by more than their intervals say, so "
        "that a controller that compensates by them leaves a part of the dead band, or rings in it. Those of the valve "
        "sheet (`eha characterise`) are better: eha tune takes them with its option --sheet.";
  } else {
    remark.to_do =
        fmt::format("A controller can compensate it: add {} {} to a positive and {} {} to a negative command.",
                    rounded(high, Role::dead_band), unit, rounded(low, Role::dead_band), unit);
  }
  if (const std::string note = ident::map_note(model, subject.sheet_says); !note.empty())
    remark.seen += " " + capitalised(note) + ".";
  if (const auto sheet = compare_with_sheet(subject, model)) {
    remark.seen += " " + sheet->seen;
    // What is compensated by numbers of which one is wrong is worse than nothing.
    if (!sheet->to_do.empty()) remark.to_do = sheet->to_do;
  }
  return remark;
}

}  // namespace

Section valve_section(const Subject& subject) {
  Section section{.title = "Valve"};
  const std::vector<const ReportedModel*> pictured = subject.pictured();
  const auto at = std::find_if(pictured.begin(), pictured.end(), [](const auto* r) { return r->model.input_map; });
  if (at == pictured.end()) return section;
  const ident::Model& model = (*at)->model;
  const ident::ValveMap& map = *model.input_map;
  const std::vector<double>& input = subject.fit.applied;
  double low = map.null - 5.0 * (map.dead_band + 0.1);
  double high = map.null + 5.0 * (map.dead_band + 0.1);
  if (!input.empty()) {
    const auto [least, greatest] = std::minmax_element(input.begin(), input.end());
    low = *least;
    high = *greatest;
  }
  Item item{.heading = "Static map of the valve in " + model.name + "; the dead band is shaded, the null dashed"};
  item.figure = {.title = item.heading, .panels = {valve_panel({&model}, low, high)}};
  item.remark = remark_on_valve(subject, model);
  section.items.push_back(std::move(item));
  return section;
}

}  // namespace eha::report
