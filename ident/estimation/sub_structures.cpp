// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/sub_structures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "ident/estimation/left_out.hpp"
#include "ident/estimation/valve_starts.hpp"
#include "ident/structure/parameter_requests.hpp"

namespace eha::ident {
namespace {

constexpr double kBaseOrderOfIntegers = 1.0;

/// Whether the requests let the parameter be held at a value.
bool allows(const StructureOptions& asked, const StructureParameter& parameter, double value) {
  const ParameterRequest* request = find_request(asked, parameter);
  const double lower = request != nullptr ? request->lower.value_or(parameter.lower) : parameter.lower;
  const double upper = request != nullptr ? request->upper.value_or(parameter.upper) : parameter.upper;
  return value >= lower && value <= upper;
}

void hold(StructureOptions& asked, StructureParameter& parameter, double value) {
  std::erase_if(asked.parameters, [&](const ParameterRequest& r) { return r.name == parameter.key.name; });
  parameter.freedom = Freedom::held;
  parameter.value = value;
}

/// The structure with a parameter held that its family holds until a request frees it.
template <typename Member>
void add_held(const StructureOptions& asked, double value, const Member& member, std::vector<StructureOptions>& all) {
  const StructureParameter& parameter = member(asked.structure);
  if (!is_estimated(asked, parameter) || !allows(asked, parameter, value)) return;
  StructureOptions smaller = asked;
  hold(smaller, member(smaller.structure), value);
  all.push_back(std::move(smaller));
}

/// Free orders of the denominator at whole numbers, where these are distinct.
std::optional<StructureOptions> with_whole_orders(const StructureOptions& asked) {
  StructureOptions smaller = asked;
  bool any = false;
  double last = -1.0;
  for (StructureTerm& term : smaller.structure.denominator) {
    double order = requested(asked, term.order);
    if (is_estimated(asked, term.order)) {
      any = true;
      order = std::round(order);
      if (!allows(asked, term.order, order)) return {};
      hold(smaller, term.order, order);
      // Constant, as in a structure of integer orders, which then has a finite state.
      term.order.freedom = Freedom::constant;
    }
    if (!(order > last)) return {};
    last = order;
  }
  return any ? std::optional(smaller) : std::nullopt;
}

bool is_polynomial(const Structure& structure) { return structure.base_order || has_finite_state(structure); }

bool has_coefficient_request(const StructureOptions& asked) {
  const auto named = [&](const StructureTerm& term) { return find_request(asked, term.coefficient) != nullptr; };
  const Structure& structure = asked.structure;
  return std::any_of(structure.numerator.begin(), structure.numerator.end(), named) ||
         std::any_of(structure.denominator.begin(), structure.denominator.end(), named);
}

void count_numerator_anew(Structure& structure) {
  const std::size_t terms = structure.numerator.size();
  for (std::size_t j = 0; j < terms; ++j) {
    structure.numerator[j].coefficient.key = numerator_key(j, terms);
    structure.numerator[j].order.key = numerator_order_key(j, terms);
  }
}

/// A polynomial of one degree less, whose numerator may have no higher degree, or with a pole held at 0.
void add_lower_degrees(const StructureOptions& asked, std::vector<StructureOptions>& all) {
  if (!is_polynomial(asked.structure) || has_coefficient_request(asked)) return;
  const auto is_free = [](const StructureTerm& term) { return term.coefficient.freedom == Freedom::free; };
  const std::vector<StructureTerm>& denominator = asked.structure.denominator;
  if (denominator.size() > 2 && is_free(denominator.back())) {
    StructureOptions smaller = asked;
    smaller.structure.denominator.pop_back();
    const std::size_t terms = smaller.structure.denominator.size();
    if (smaller.structure.numerator.size() > terms) smaller.structure.numerator.resize(terms);
    count_numerator_anew(smaller.structure);
    all.push_back(std::move(smaller));
  }
  if (denominator.size() > 2 && !asked.structure.base_order && is_free(denominator.front())) {
    StructureOptions smaller = asked;
    StructureParameter& lowest = smaller.structure.denominator.front().coefficient;
    lowest.freedom = Freedom::constant;
    lowest.value = 0.0;
    all.push_back(std::move(smaller));
  }
  if (asked.structure.numerator.size() > 1 && is_free(asked.structure.numerator.back())) {
    StructureOptions smaller = asked;
    smaller.structure.numerator.pop_back();
    count_numerator_anew(smaller.structure);
    all.push_back(std::move(smaller));
  }
}

}  // namespace

std::string signature(const StructureOptions& asked) {
  std::string text = asked_behind_valve(asked) ? "behind a valve: " : "";
  const auto add = [&](const StructureParameter& parameter) {
    if (is_estimated(asked, parameter)) {
      text += "*,";
    } else {
      text += fmt::format("{},", requested(asked, parameter));
    }
  };
  const Structure& structure = asked.structure;
  for (const StructureTerm& term : structure.numerator) add(term.order);
  text += '/';
  for (const StructureTerm& term : structure.denominator) add(term.order);
  // A pole held at 0.
  add(structure.denominator.front().coefficient);
  add(structure.delay);
  if (structure.base_order) add(*structure.base_order);
  return text;
}

std::vector<StructureOptions> sub_structures(const StructureOptions& asked) {
  std::vector<StructureOptions> all;
  if (asked_behind_valve(asked)) all.push_back(without_valve(asked));
  add_held(
      asked, 0.0, [](auto& structure) -> auto& { return structure.delay; }, all);
  if (asked.structure.numerator.size() == 1 && asked.structure.numerator[0].order.freedom == Freedom::held) {
    const double whole = asked.structure.numerator[0].order.value;
    add_held(
        asked, whole, [](auto& structure) -> auto& { return structure.numerator[0].order; }, all);
  }
  if (asked.structure.base_order) {
    const std::size_t before = all.size();
    add_held(
        asked, kBaseOrderOfIntegers, [](auto& structure) -> auto& { return *structure.base_order; }, all);
    // A polynomial in s, whose poles can be guessed.
    if (all.size() > before) all.back().structure.base_order.reset();
  }
  if (const auto whole = with_whole_orders(asked)) all.push_back(*whole);
  if (const StructureTerm& highest = asked.structure.denominator.back(); is_estimated(asked, highest.order)) {
    if (const auto without = without_order(asked, highest.order.key)) all.push_back(*without);
  }
  add_lower_degrees(asked, all);
  return all;
}

}  // namespace eha::ident
