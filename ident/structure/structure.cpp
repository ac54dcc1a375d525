// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/structure/structure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace eha::ident {
namespace {

bool is_constant(const StructureParameter& parameter) { return parameter.freedom == Freedom::constant; }

template <typename Visit>
void visit_orders(const Structure& structure, const Visit& visit) {
  for (std::size_t i = structure.denominator.size(); i-- > 0;) visit(structure.denominator[i].order);
  for (const StructureTerm& term : structure.numerator) visit(term.order);
}

/// "a2 s^n2+a1 s+a0", the highest order first.
std::string formula_of(const std::vector<StructureTerm>& terms) {
  std::string text;
  for (std::size_t i = terms.size(); i-- > 0;) {
    const StructureParameter& coefficient = terms[i].coefficient;
    const StructureParameter& order = terms[i].order;
    if (is_constant(coefficient) && std::abs(coefficient.value) <= 0.0) continue;
    if (!text.empty()) text += '+';
    text += coefficient.key.name;
    if (!is_constant(order)) {
      text += fmt::format(" s^{}", order.key.name);
    } else if (order.value > 1.0) {
      text += fmt::format(" s^{:g}", order.value);
    } else if (order.value > 0.0) {
      text += " s";
    }
  }
  return text;
}

}  // namespace

bool has_equal_steps(const Structure& structure) {
  if (structure.base_order) return true;
  for (std::size_t k = 0; k < structure.denominator.size(); ++k) {
    const StructureParameter& order = structure.denominator[k].order;
    if (!is_constant(order) || std::abs(order.value - static_cast<double>(k)) > 0.0) return false;
  }
  return structure.denominator.size() > 1;
}

bool has_finite_state(const Structure& structure) { return !structure.base_order && has_equal_steps(structure); }

std::size_t state_count(const Structure& structure) { return structure.denominator.size() - 1; }

std::string formula_of(const Structure& structure) {
  std::string numerator = formula_of(structure.numerator);
  if (structure.numerator.size() > 1) numerator = fmt::format("({})", numerator);
  return fmt::format("{}/({})", numerator, formula_of(structure.denominator));
}

bool must_be_strictly_proper(const Structure& structure) {
  bool moves = structure.numerator.size() == 1;
  visit_orders(structure, [&](const StructureParameter& order) { moves = moves || !is_constant(order); });
  return moves;
}

std::vector<const StructureParameter*> map_parameters(const InputMap& map) {
  if (!map.valve) return {&map.bias};
  return {&map.valve->null, &map.valve->dead_band, &map.valve->negative_gain_ratio};
}

std::vector<const StructureParameter*> requestable_parameters(const Structure& structure) {
  std::vector<const StructureParameter*> all;
  for (std::size_t i = structure.denominator.size(); i-- > 0;) all.push_back(&structure.denominator[i].coefficient);
  visit_orders(structure, [&](const StructureParameter& order) { all.push_back(&order); });
  if (structure.base_order) all.push_back(&*structure.base_order);
  for (const StructureTerm& term : structure.numerator) all.push_back(&term.coefficient);
  if (structure.grey_box) {
    for (const StructureParameter& parameter : structure.grey_box->parameters) all.push_back(&parameter);
  }
  all.push_back(&structure.delay);
  for (const StructureParameter* parameter : map_parameters(structure.input_map)) all.push_back(parameter);
  all.push_back(&structure.initial_output);
  std::erase_if(all, [](const StructureParameter* parameter) { return is_constant(*parameter); });
  return all;
}

std::vector<const StructureParameter*> listed_parameters(const Structure& structure) {
  std::vector<const StructureParameter*> all;
  if (structure.grey_box) {
    for (const StructureParameter& parameter : structure.grey_box->parameters) all.push_back(&parameter);
  }
  for (const StructureTerm& term : structure.numerator) all.push_back(&term.coefficient);
  for (std::size_t i = structure.denominator.size(); i-- > 0;) all.push_back(&structure.denominator[i].coefficient);
  if (structure.base_order) all.push_back(&*structure.base_order);
  visit_orders(structure, [&](const StructureParameter& order) { all.push_back(&order); });
  all.push_back(&structure.delay);
  for (const StructureParameter* parameter : map_parameters(structure.input_map)) all.push_back(parameter);
  all.push_back(&structure.initial_output);
  std::erase_if(all, [](const StructureParameter* parameter) { return !parameter->listed; });
  return all;
}

}  // namespace eha::ident
