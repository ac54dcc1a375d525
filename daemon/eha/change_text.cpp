// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/change_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>
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

std::vector<std::string> change_sentences(const ident::PlantChange& change, const ident::Model& model, Shows shows) {
  std::vector<std::string> sentences;
  const auto add = [&](std::string sentence) {
    if (!sentence.empty()) sentences.push_back(std::move(sentence));
  };
  std::vector<std::string> changed;
  for (const ParameterChange& p : change.parameters) {
    if (!p.changed) continue;
    add(change_sentence(p, model, shows));
    changed.push_back(p.name);
  }
  add(ident::unit_instead(change));
  add(ident::map_instead(changed, model.input_map.has_value()));
  add(whose_valve(change, model));
  for (const ParameterChange& p : change.parameters) add(ident::hidden_sentence(p, model));
  for (const std::string& name : change.other_unit) add(ident::other_unit_sentence(name));
  for (const std::string& name : change.undetermined) add(name + " is not determined by both records");
  return sentences;
}

std::string change_lines(const ident::PlantChange& change, const ident::Model& model, Shows shows) {
  std::string text;
  for (const std::string& sentence : change_sentences(change, model, shows)) text += "  " + sentence + "\n";
  return text;
}

}  // namespace eha::cli
