// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/model_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

namespace eha::config {
namespace {

using ident::Freedom;

std::string number(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

/// Whether the family, with its degrees and no other keys, gives this structure.
bool is_of_family(const ident::Structure& structure) {
  const auto families = ident::structure_families();
  const auto family =
      std::find_if(families.begin(), families.end(), [&](const auto& one) { return one.name == structure.family; });
  if (family == families.end()) return false;
  const ident::Structure made = family->make(structure.degrees.value_or(ident::Degrees{}));
  return made.numerator == structure.numerator && made.denominator == structure.denominator &&
         made.base_order == structure.base_order;
}

std::string term_table(std::string_view list, const std::vector<ident::StructureTerm>& terms) {
  std::string text = fmt::format("{} = [\n", list);
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const auto& [coefficient, order] = terms[k];
    text += fmt::format("  {{ order = {}", number(order.value));
    if (order.freedom == Freedom::free) {
      text += fmt::format(", free = true, lower = {}, upper = {}", number(order.lower), number(order.upper));
    }
    const bool normalised = list == "denominator" && k == ident::normalised_index(terms.size());
    if (coefficient.freedom != Freedom::free && !normalised) {
      text += fmt::format(", coefficient = {}", number(coefficient.value));
    }
    text += " },\n";
  }
  return text + "]\n";
}

std::string structure_keys(const ident::Structure& structure) {
  if (!is_of_family(structure)) {
    return fmt::format("structure = \"{}\"\n{}{}", ident::kTermsFamily, term_table("numerator", structure.numerator),
                       term_table("denominator", structure.denominator));
  }
  std::string text = fmt::format("structure = \"{}\"\n", structure.family);
  if (structure.degrees) {
    text += fmt::format("poles = {}\nzeros = {}\n", structure.degrees->poles, structure.degrees->zeros);
  }
  return text;
}

}  // namespace

std::string model_table(const ident::StructureOptions& asked) {
  const ident::Structure& structure = asked.structure;
  std::string text = fmt::format("[[model]]\nname = \"{}\"\n{}", asked.name, structure_keys(structure));
  const ident::InputMapKind& map = ident::input_map_kind_of(structure);
  if (!map.suffix.empty()) text += fmt::format("input_map = \"{}\"\n", map.name);
  if (structure.delay.freedom == Freedom::free) text += "delay = \"free\"\n";
  if (structure.delay.value > 0.0) text += fmt::format("delay_s = {}\n", number(structure.delay.value));
  if (asked.initial_state == ident::InitialState::none) text += "initial_state = \"none\"\n";
  if (asked.initial_state == ident::InitialState::estimated) text += "initial_state = \"estimated\"\n";
  for (const ident::ParameterRequest& request : asked.parameters) {
    text += fmt::format("[[model.parameter]]\nname = \"{}\"\n", request.name);
    if (request.fixed) text += fmt::format("fixed = {}\n", *request.fixed);
    if (request.start) text += fmt::format("start = {}\n", number(*request.start));
    if (request.lower) text += fmt::format("lower = {}\n", number(*request.lower));
    if (request.upper) text += fmt::format("upper = {}\n", number(*request.upper));
  }
  return text;
}

}  // namespace eha::config
