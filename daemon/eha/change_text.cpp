// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/change_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

#include "ident/model/parameter_text.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;
using ident::ParameterChange;

std::string with_unit(const std::string& number, const std::string& unit) {
  return unit.empty() ? number : number + " " + unit;
}

bool is_of_valve(const ParameterChange& p) {
  return p.role == ident::ParameterRole::valve_null || p.role == ident::ParameterRole::dead_band;
}

/// Says whose number a changed null or dead band is; empty if none changed.
std::string whose_valve(const ident::PlantChange& change, const ident::Model& model) {
  std::vector<std::string> names;
  for (const ParameterChange& p : change.parameters) {
    if (p.changed && is_of_valve(p)) names.push_back(p.name);
  }
  if (names.empty()) return {};
  return fmt::format(
      "{0} {1} of the {2} fits, for comparing records: another structure gives slightly other numbers, and dry "
      "friction or a leak shifts them. `eha characterise` measures the valve's own, for [following]",
      fmt::join(names, " and "), names.size() == 1 ? "is that" : "are those", model.name);
}

}  // namespace

std::string change_sentence(const ParameterChange& p, const ident::Model& model, Shows shows) {
  const std::string unit = ident::unit_of(p, model);
  return fmt::format("{} {} by {}, joint +- {} ({} to {})", p.name, shows == Shows::change ? "moved" : "differs",
                     with_unit(ident::rounded_to(p.after - p.before, p.half_width), unit),
                     with_unit(fmt::format("{:.2g}", p.half_width), unit), ident::rounded_to(p.before, p.half_width),
                     ident::rounded_to(p.after, p.half_width));
}

nlohmann::ordered_json change_json(const ident::PlantChange& change, const ident::Model& model) {
  Json parameters = Json::array();
  for (const ParameterChange& p : change.parameters) {
    parameters.push_back({{"name", p.name},
                          {"unit", ident::unit_of(p, model)},
                          {"before", p.before},
                          {"after", p.after},
                          {"difference", p.after - p.before},
                          {"std", p.std},
                          {"joint_half_width", p.half_width},
                          {"joint_half_width_of_noise", p.of_noise},
                          {"follows", p.follows},
                          {"changed", p.changed}});
  }
  return {{"changed", change.changed},
          {"parameters", parameters},
          {"undetermined", change.undetermined},
          {"other_unit", change.other_unit}};
}

std::string change_sentences(const ident::PlantChange& change, const ident::Model& model, Shows shows) {
  std::string text;
  for (const ParameterChange& p : change.parameters) {
    if (p.changed) text += "  " + change_sentence(p, model, shows) + "\n";
  }
  if (const std::string unit = ident::unit_instead(change); !unit.empty()) text += "  " + unit + "\n";
  std::vector<std::string> changed;
  for (const ParameterChange& p : change.parameters) {
    if (p.changed) changed.push_back(p.name);
  }
  if (const std::string instead = ident::map_instead(changed, model.input_map.has_value()); !instead.empty()) {
    text += "  " + instead + "\n";
  }
  if (const std::string whose = whose_valve(change, model); !whose.empty()) text += "  " + whose + "\n";
  for (const ParameterChange& p : change.parameters) {
    if (const std::string hidden = ident::hidden_sentence(p, model); !hidden.empty()) text += "  " + hidden + "\n";
  }
  for (const std::string& name : change.other_unit) text += "  " + ident::other_unit_sentence(name) + "\n";
  for (const std::string& name : change.undetermined) text += "  " + name + " is not determined by both records\n";
  return text;
}

}  // namespace eha::cli
