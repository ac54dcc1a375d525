// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/variants.hpp"

#include "ident/structure/parameter_requests.hpp"

namespace eha::ident {
namespace {

LinearQuantity quantity(const StructureOptions& asked, const StructureParameter& parameter) {
  LinearQuantity q;
  q.fixed = !is_estimated(asked, parameter);
  q.value = requested(asked, parameter);
  if (const ParameterRequest* request = find_request(asked, parameter)) {
    q.lower = request->lower.value_or(q.lower);
    q.upper = request->upper.value_or(q.upper);
  }
  return q;
}

/// With a finite state, moving before t = 0.
Variant variant_moving(const StructureOptions& asked) {
  const Variant at_rest = variant_at_rest(asked);
  const auto states = static_cast<int>(state_count(asked.structure));
  // A constant input switched on at t = 0 is, for a finite state, one of the free responses.
  Variant moving = at_rest;
  moving.linear.solve_bias = false;
  moving.bias_coordinate = false;
  moving.linear.initial_states = states;
  if (!is_estimated(asked, asked.structure.initial_output)) {
    // Without a free offset nothing else does the work of the bias.
    moving.linear.solve_bias = at_rest.linear.solve_bias;
    moving.bias_coordinate = at_rest.bias_coordinate;
  } else if (find_request(asked, asked.structure.initial_output) == nullptr) {
    // The constant is one of the free responses when 1/D's step response is: see LinearPart::first_state.
    moving.linear.initial_output.fixed = true;
    moving.linear.initial_states = states + 1;
    moving.linear.first_state = -1;
  }
  return moving;
}

}  // namespace

Variant variant_at_rest(const StructureOptions& asked) {
  const Structure& structure = asked.structure;
  Variant at_rest;
  for (const StructureTerm& term : structure.numerator) {
    at_rest.linear.numerator.push_back(quantity(asked, term.coefficient));
  }
  at_rest.linear.initial_output = quantity(asked, structure.initial_output);
  const LinearQuantity bias = quantity(asked, structure.input_map.bias);
  if (bias.fixed) at_rest.linear.fixed_bias = bias.value;
  // With one numerator term the bias enters linearly, beside the gain; bounds on it make it a coordinate.
  const ParameterRequest* request = find_request(asked, structure.input_map.bias);
  const bool bounded = request != nullptr && (request->lower || request->upper);
  at_rest.linear.solve_bias = !bias.fixed && !bounded && structure.numerator.size() == 1;
  at_rest.bias_coordinate = !bias.fixed && !at_rest.linear.solve_bias;
  at_rest.linear.solve_ratio = ratio_enters_linearly(asked);
  return at_rest;
}

std::vector<Variant> variants(const StructureOptions& asked, std::size_t windows, bool at_rest_before) {
  const Variant at_rest = variant_at_rest(asked);
  if (wants_past_input(asked)) {
    std::vector<Variant> excited;
    for (const std::size_t shared : {4, 2, 1}) {
      excited.push_back(at_rest);
      excited.back().linear.past_shared = shared;
      excited.back().linear.initial_states = static_cast<int>((windows + shared - 1) / shared);
    }
    return excited;
  }
  if (!has_finite_state(asked.structure) || asked.initial_state == InitialState::none) return {at_rest};
  if (asked.initial_state == InitialState::estimated) return {variant_moving(asked)};
  if (at_rest_before) return {at_rest};
  return {at_rest, variant_moving(asked)};
}

bool treats_the_past_as(const LinearPart& a, const LinearPart& b) {
  return a.initial_states == b.initial_states && a.first_state == b.first_state && a.past_shared == b.past_shared;
}

std::size_t free_parameters(const Parametrisation& parametrisation, const LinearPart& linear) {
  std::size_t free = parametrisation.coordinates().size() + static_cast<std::size_t>(linear.initial_states);
  for (const LinearQuantity& q : linear.numerator) free += q.fixed ? 0 : 1;
  return free + (linear.solve_bias ? 1 : 0) + (linear.solve_ratio ? 1 : 0) + (linear.initial_output.fixed ? 0 : 1);
}

}  // namespace eha::ident
