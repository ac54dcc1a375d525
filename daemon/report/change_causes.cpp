// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/change_causes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>

namespace eha::report {
namespace {

/// Parameters with common causes.
struct CommonCause {
  std::string_view causes;
  bool (*has)(ident::ParameterRole role);
};

bool is_gain(ident::ParameterRole role) { return role == ident::ParameterRole::numerator_coefficient; }

bool is_ratio(ident::ParameterRole role) { return role == ident::ParameterRole::negative_gain_ratio; }

bool is_of_valve(ident::ParameterRole role) {
  return (ident::is_of_map(role) && !is_ratio(role)) || role == ident::ParameterRole::input_bias;
}

bool is_of_dynamics(ident::ParameterRole role) { return !is_gain(role) && !is_ratio(role) && !is_of_valve(role); }

constexpr std::string_view kLeakFirst =
    "a leak past the piston, as said above, with which `eha characterise` finds a drift inside the dead band; without "
    "one the valve (wear, dirt, the offset of its amplifier) or dry friction";
constexpr std::string_view kLeakAndValve =
    "the valve (wear, dirt, the offset of its amplifier), and a leak past the piston beside it, as said above: two "
    "valve "
    "sheets (`eha characterise`) compare the valve alone";
constexpr std::string_view kFrictionFirst =
    "dry friction, as said above: look at seals, guides and load; else the valve (wear, dirt, the offset of its "
    "amplifier)";

constexpr std::string_view kScaleOrSupply =
    "the output is greater or smaller by one factor and no other parameter is shown to have changed, as with another "
    "scale of the sensor (its calibration, amplifier or unit: hold a known distance against a ruler) or another supply "
    "pressure; else dry "
    "friction, the load, the valve or a leak";

/// Whether the gains alone changed, all by one factor: as a sensor of another scale multiplies the output. A gain that
/// is not shown to have changed has to allow that factor, too.
bool is_one_factor(const std::vector<const ident::PlantChange*>& changes) {
  for (const ident::PlantChange* change : changes) {
    double lowest = 0.0;
    double highest = std::numeric_limits<double>::infinity();
    for (const ident::ParameterChange& p : change->parameters) {
      if (p.changed && !is_gain(p.role)) return false;
      if (!is_gain(p.role)) continue;
      if (!(p.before * p.after > 0.0)) return false;
      const double wide = p.half_width / std::abs(p.before);
      lowest = std::max(lowest, p.after / p.before - wide);
      highest = std::min(highest, p.after / p.before + wide);
    }
    if (!(lowest <= highest)) return false;
  }
  return true;
}

constexpr std::array kCommonCauses{
    CommonCause{
        "commonly the valve (wear, dirt, the offset of its amplifier), else dry friction, the load or a leak past the "
        "piston, with which `eha characterise` finds a drift inside the dead band",
        is_of_valve},
    CommonCause{
        "commonly the load, which hangs on one side of the piston (on a vertical cylinder its weight speeds up one "
        "way and slows down the other), or dry friction, else the valve or a leak past the piston",
        is_ratio},
    CommonCause{"commonly the supply pressure, dry friction, the load or the sensor's scale, else the valve or a leak",
                is_gain},
    CommonCause{"commonly the load, as another moving mass changes time constant and natural frequency, the oil (its "
                "temperature, or air in it), or a slow or sticking spool of the valve",
                is_of_dynamics}};

}  // namespace

std::string causes_of(const std::vector<const ident::PlantChange*>& changes, MapCause found) {
  for (const ident::PlantChange* change : changes) {
    if (const std::string unit = ident::unit_instead(*change); !unit.empty()) {
      return "Check the units of the records first: a gain changed by the factor between two units.";
    }
  }
  std::string text;
  const std::string_view of_map = found == MapCause::leak             ? kLeakFirst
                                  : found == MapCause::leak_and_valve ? kLeakAndValve
                                                                      : kFrictionFirst;
  for (const CommonCause& kind : kCommonCauses) {
    std::vector<std::string> names;
    for (const ident::PlantChange* change : changes) {
      for (const ident::ParameterChange& p : change->parameters) {
        if (!p.changed || !kind.has(p.role) || std::find(names.begin(), names.end(), p.name) != names.end()) continue;
        names.push_back(p.name);
      }
    }
    const bool is_found = found != MapCause::unknown && kind.has == &is_of_valve;
    const std::string_view causes = is_found                                         ? of_map
                                    : kind.has == &is_gain && is_one_factor(changes) ? kScaleOrSupply
                                                                                     : kind.causes;
    if (!names.empty()) text += fmt::format("{}: {}. ", fmt::join(names, ", "), causes);
  }
  return text.empty() ? text : text + "The record shows which parameter changed, not why.";
}

std::string advice_on(const std::vector<const ident::PlantChange*>& changes, MapCause found, std::string_view then) {
  const std::string causes = causes_of(changes, found);
  return causes.empty() ? causes : fmt::format("Look on the bench for what changed. {} {}", causes, then);
}

bool changes_valve(const ident::PlantChange& change) {
  return std::any_of(change.parameters.begin(), change.parameters.end(),
                     [](const auto& p) { return p.changed && is_of_valve(p.role); });
}

}  // namespace eha::report
