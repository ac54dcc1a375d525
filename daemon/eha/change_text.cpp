// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/change_text.hpp"

#include <fmt/format.h>

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;
using ident::ParameterChange;

std::string with_unit(const std::string& number, const std::string& unit) {
  return unit.empty() ? number : number + " " + unit;
}

}  // namespace

std::string change_sentence(const ParameterChange& p, const ident::Model& model) {
  const std::string unit = ident::unit_of(p, model);
  return fmt::format("{} moved by {}, joint +- {} ({:.4g} to {:.4g})", p.name,
                     with_unit(fmt::format("{:.3g}", p.after - p.before), unit),
                     with_unit(fmt::format("{:.2g}", p.half_width), unit), p.before, p.after);
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
  return {{"changed", change.changed}, {"parameters", parameters}, {"undetermined", change.undetermined}};
}

std::string change_sentences(const ident::PlantChange& change, const ident::Model& model) {
  std::string text;
  for (const ParameterChange& p : change.parameters) {
    if (p.changed) text += "  " + change_sentence(p, model) + "\n";
  }
  for (const ParameterChange& p : change.parameters) {
    if (const std::string hidden = ident::hidden_sentence(p, model); !hidden.empty()) text += "  " + hidden + "\n";
  }
  for (const std::string& name : change.undetermined) text += "  " + name + " is not determined by both records\n";
  return text;
}

}  // namespace eha::cli
