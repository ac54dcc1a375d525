// SPDX-License-Identifier: GPL-3.0-or-later
// Every named structure as data. A new structure is a function here and a row of kFamilies.
#include "ident/structure/structures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "core/error.hpp"
#include "ident/structure/order_bounds.hpp"

namespace eha::ident {
namespace {

// A fractional model of at least order 2 would be unstable with positive coefficients.
constexpr double kHighestBaseOrder = 1.99;

StructureTerm denominator_term(std::size_t index, std::size_t terms, double order) {
  const Freedom freedom = index == normalised_index(terms) ? Freedom::constant : Freedom::free;
  return {.coefficient = {.key = coefficient_key(index), .value = 1.0, .freedom = freedom},
          .order = {.key = order_key(index), .value = order}};
}

StructureTerm numerator_term(std::size_t index, std::size_t terms, double order) {
  return {.coefficient = {.key = numerator_key(index, terms), .freedom = Freedom::free},
          .order = {.key = numerator_order_key(index, terms), .value = order}};
}

/// Terms of orders 0, 1, 2, ..., in s or in s^q; model files do not list these orders.
Structure polynomials(const Degrees& degrees) {
  if (degrees.poles < 1 || degrees.poles > kHighestDegree || degrees.zeros < 0 || degrees.zeros > degrees.poles) {
    throw ConfigError(fmt::format("expected 1 to {} poles and at most as many zeros, got {} and {}", kHighestDegree,
                                  degrees.poles, degrees.zeros));
  }
  Structure structure;
  structure.degrees = degrees;
  const auto terms = static_cast<std::size_t>(degrees.poles) + 1;
  for (std::size_t k = 0; k < terms; ++k) {
    structure.denominator.push_back(denominator_term(k, terms, static_cast<double>(k)));
    structure.denominator.back().order.listed = false;
  }
  const auto zeros = static_cast<std::size_t>(degrees.zeros) + 1;
  for (std::size_t k = 0; k < zeros; ++k) {
    structure.numerator.push_back(numerator_term(k, zeros, static_cast<double>(k)));
    structure.numerator.back().order.listed = false;
  }
  return structure;
}

/// A polynomial in s with one of its poles at 0, and no zero.
Structure integrating(int poles) {
  Structure structure = polynomials({poles, 0});
  structure.degrees.reset();
  structure.denominator[0].coefficient.freedom = Freedom::constant;
  structure.denominator[0].coefficient.value = 0.0;
  return structure;
}

/// Frees an order that starts at its value.
void set_free(StructureParameter& order, double search_lower, double search_upper) {
  order.freedom = Freedom::free;
  order.lower = kLowestOrder;
  order.upper = kHighestOrder;
  order.search_lower = search_lower;
  order.search_upper = search_upper;
}

constexpr auto kFamilies = std::to_array<StructureFamily>({
    {"integrator_lag", false, [](const Degrees&) { return structures::integrator_lag(); }},
    {"cylinder", false, [](const Degrees&) { return structures::cylinder(); }},
    {"io1", false, [](const Degrees&) { return structures::io1(); }},
    {"io", true, [](const Degrees& degrees) { return structures::io(degrees); }},
    {"io3", false, [](const Degrees&) { return structures::io3(); }},
    {"fo", false, [](const Degrees&) { return structures::fo(); }},
    {"commensurate", true, [](const Degrees& degrees) { return structures::commensurate(degrees); }},
    {"lag", false, [](const Degrees&) { return structures::lag(); }},
    {"friction", false, [](const Degrees&) { return structures::grey_box(friction_kind()); }},
    {"outflow", false, [](const Degrees&) { return structures::grey_box(outflow_kind()); }},
    {"overflow", false, [](const Degrees&) { return structures::grey_box(overflow_kind()); }},
});

Structure without_map(Structure structure) {
  structure.input_map = {};
  return structure;
}

constexpr auto kInputMaps =
    std::to_array<InputMapKind>({{"none", "", without_map}, {"valve", "_valve", structures::behind_valve}});

}  // namespace

namespace structures {

Structure io(const Degrees& degrees) {
  Structure structure = polynomials(degrees);
  structure.family = "io";
  structure.formula = fmt::format("{} pole{}, {} zero{}", degrees.poles, degrees.poles == 1 ? "" : "s", degrees.zeros,
                                  degrees.zeros == 1 ? "" : "s");
  if (degrees.poles == 2 && degrees.zeros < 2) structure.formula = formula_of(structure);
  return structure;
}

Structure integrator_lag() {
  Structure structure = integrating(2);
  structure.family = "integrator_lag";
  structure.formula = formula_of(structure);
  return structure;
}

Structure cylinder() {
  Structure structure = integrating(3);
  structure.family = "cylinder";
  structure.formula = formula_of(structure);
  return structure;
}

Structure io1() {
  Structure structure = polynomials({1, 0});
  structure.family = "io1";
  structure.formula = formula_of(structure);
  structure.degrees.reset();
  return structure;
}

Structure io3(int zeros) {
  Structure structure = polynomials({3, zeros});
  structure.family = "io3";
  structure.formula = formula_of(structure);
  structure.degrees.reset();
  return structure;
}

Structure fo() {
  Structure structure;
  structure.family = "fo";
  structure.formula = "K s^b0/(a2 s^n2+a1 s^n1+a0 s^n0)";
  structure.denominator = {denominator_term(0, 3, 0.0), denominator_term(1, 3, 0.9), denominator_term(2, 3, 1.8)};
  set_free(structure.denominator[1].order, 0.3, 1.2);
  set_free(structure.denominator[2].order, 1.2, 2.2);
  structure.numerator = {numerator_term(0, 1, 0.0)};
  set_free(structure.numerator[0].order, 0.0, 0.6);
  structure.numerator[0].order.lower = 0.0;
  structure.numerator[0].order.freedom = Freedom::held;
  return structure;
}

Structure fo_with_zero() {
  Structure structure = fo();
  structure.numerator = {numerator_term(0, 2, 0.0), numerator_term(1, 2, 1.0)};
  structure.formula = formula_of(structure);
  return structure;
}

Structure commensurate(const Degrees& degrees) {
  Structure structure = polynomials(degrees);
  structure.family = "commensurate";
  structure.formula = fmt::format("in s^q, degree {}, numerator {}", degrees.poles, degrees.zeros);
  structure.base_order = {.key = base_order_key(),
                          .value = 0.9,
                          .lower = kLowestOrder,
                          .upper = kHighestBaseOrder,
                          .search_lower = 0.4,
                          .search_upper = 1.2,
                          .freedom = Freedom::free};
  return structure;
}

Structure lag() {
  Structure structure;
  structure.family = "lag";
  structure.formula = "K/(a1 s^n1+a0)";
  structure.denominator = {denominator_term(0, 2, 0.0), denominator_term(1, 2, 0.9)};
  set_free(structure.denominator[1].order, 0.3, 1.9);
  structure.numerator = {numerator_term(0, 1, 0.0)};
  return structure;
}

Structure grey_box(const GreyBoxKind& kind) {
  Structure structure = kind.integrates ? integrator_lag() : io();
  structure.family = kind.name;
  structure.formula = kind.formula;
  structure.degrees.reset();
  const auto hold = [](StructureParameter& parameter) {
    parameter.freedom = Freedom::constant;
    parameter.listed = false;
  };
  for (StructureTerm& term : structure.numerator) hold(term.coefficient);
  for (StructureTerm& term : structure.denominator) hold(term.coefficient);
  GreyBoxStructure& box = structure.grey_box.emplace();
  box.kind = &kind;
  for (std::size_t i = 0; i < kind.parameters.size(); ++i) {
    box.parameters.push_back({.key = grey_box_key(kind.parameters[i].name, i),
                              .lower = kind.parameters[i].positive ? 0.0 : -std::numeric_limits<double>::infinity(),
                              .freedom = Freedom::free});
  }
  if (kind.bias_is_reference) structure.input_map.bias.freedom = Freedom::constant;
  return structure;
}

Structure behind_valve(Structure structure) {
  if (structure.grey_box)
    throw ConfigError(fmt::format("input_map: expected none before {}, got valve", structure.family));
  structure.input_map.valve.emplace();
  structure.input_map.bias.freedom = Freedom::constant;
  structure.input_map.bias.value = 0.0;
  structure.input_map.bias.listed = false;
  return structure;
}

}  // namespace structures

std::span<const InputMapKind> input_map_kinds() { return kInputMaps; }

const InputMapKind& input_map_kind_of(const Structure& structure) {
  return structure.input_map.valve ? kInputMaps.back() : kInputMaps.front();
}

std::span<const StructureFamily> structure_families() { return kFamilies; }

const StructureFamily& structure_family(std::string_view name) {
  const auto found = std::find_if(kFamilies.begin(), kFamilies.end(),
                                  [&](const StructureFamily& family) { return family.name == name; });
  if (found != kFamilies.end()) return *found;
  std::vector<std::string_view> names;
  for (const StructureFamily& family : kFamilies) names.push_back(family.name);
  throw ConfigError(fmt::format("structure: expected one of {}, got \"{}\"", fmt::join(names, ", "), name));
}

}  // namespace eha::ident
