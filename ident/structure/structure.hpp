// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "ident/grey_box/grey_box_kind.hpp"
#include "ident/structure/parameter_role.hpp"

namespace eha::ident {

/// Source of the value of a structure's parameter.
enum class Freedom {
  constant,  ///< the structure; a request for the parameter is refused
  held,      ///< the structure, until a request frees it
  free,      ///< the record, until a request holds it
};

/// One parameter of a structure: role, start of the search, bounds and search box.
struct StructureParameter {
  ParameterKey key;
  double value = 0.0;  ///< start of the search when free, else the value
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double search_lower = -std::numeric_limits<double>::infinity();  ///< box of the global search, inside the bounds
  double search_upper = std::numeric_limits<double>::infinity();
  Freedom freedom = Freedom::constant;
  bool listed = true;  ///< among the parameters of a model file

  bool operator==(const StructureParameter&) const = default;
};

/// coefficient * s^order. The search chooses start and box of a coefficient, because they depend on the record.
struct StructureTerm {
  StructureParameter coefficient;
  StructureParameter order;

  bool operator==(const StructureTerm&) const = default;
};

/// Parameters of a valve map, see ValveMap.
struct ValveParameters {
  StructureParameter null{.key = valve_null_key(), .freedom = Freedom::free};
  StructureParameter dead_band{.key = dead_band_key(), .lower = 0.0, .freedom = Freedom::free};
  StructureParameter negative_gain_ratio{.key = negative_gain_ratio_key(), .value = 1.0, .freedom = Freedom::free};
};

/// The static map between the input and G: v = u + bias, or the valve map, whose null replaces the bias.
struct InputMap {
  StructureParameter bias{.key = input_bias_key(), .freedom = Freedom::free};  ///< constant 0 with a valve map
  std::optional<ValveParameters> valve = {};
};

/// Degrees of a structure, for families that have degrees.
struct Degrees {
  int poles = 2;  ///< 1..10
  int zeros = 0;  ///< 0..poles
};

/// A plant with equations of its own in place of G, and its parameters, one an entry of the kind's list. Without a
/// request each is free; its start is found from the linear form.
struct GreyBoxStructure {
  const GreyBoxKind* kind = nullptr;
  std::vector<StructureParameter> parameters;
};

/// A family of models as data:
///   y = initial_output + G(map(u)) + free response,  G = exp(-delay s) sum_j b_j s^be_j / sum_i a_i s^al_i.
/// Terms are sorted by their order's starting value, the lowest first. The coefficient of denominator term
/// normalised_index() is 1. A new structure is one more function of structures.hpp; no other code depends on its name.
struct Structure {
  std::string family;   ///< as files and the command line spell it: "io"
  std::string formula;  ///< for tables: "K/(a1 s^n1+a0)"
  std::vector<StructureTerm> numerator;
  std::vector<StructureTerm> denominator;
  /// Shared by all terms when present: term k of numerator and denominator has order k base_order.
  std::optional<StructureParameter> base_order;
  StructureParameter delay{.key = delay_key(), .freedom = Freedom::held};  ///< lower bound 0, upper one by the record
  InputMap input_map;
  StructureParameter initial_output{.key = initial_output_key(), .freedom = Freedom::free};
  std::optional<Degrees> degrees;  ///< its degrees, if the family has degrees
  /// Numerator and denominator are then those of its linear form, constant and not listed.
  std::optional<GreyBoxStructure> grey_box = {};
};

/// Index of the denominator term whose coefficient is 1 by normalisation, that of the second lowest order.
/// @param terms  of the denominator
[[nodiscard]] constexpr std::size_t normalised_index(std::size_t terms) { return std::min<std::size_t>(1, terms - 1); }

/// Whether term k of the denominator has order k q with one q: D is then a product of sections in s^q.
[[nodiscard]] bool has_equal_steps(const Structure& structure);

/// Whether D is a polynomial in s of degree at least 1 with all its terms. Such a model has as many states as poles,
/// and its poles can be guessed from a record. The output of other models depends on all past input: they have an
/// unknown past input instead of an initial state.
[[nodiscard]] bool has_finite_state(const Structure& structure);

/// Returns the number of states of a structure that has a finite state.
[[nodiscard]] std::size_t state_count(const Structure& structure);

/// Writes K and s with names in place of values, for tables: "K/(a3 s^3+a2 s^2+a1 s)". Leaves out zero coefficients.
[[nodiscard]] std::string formula_of(const Structure& structure);

/// Whether the orders of numerator and denominator may become equal during a search. A direct part that changes with
/// the orders makes the sampled response not differentiable, so such a structure must stay strictly proper.
[[nodiscard]] bool must_be_strictly_proper(const Structure& structure);

/// Parameters of the map before G, in the order of messages and files.
[[nodiscard]] std::vector<const StructureParameter*> map_parameters(const InputMap& map);

/// Parameters that a request may name, in the order of messages.
[[nodiscard]] std::vector<const StructureParameter*> requestable_parameters(const Structure& structure);

/// Parameters that a model file lists, in its order; without the free response, which depends on the record.
[[nodiscard]] std::vector<const StructureParameter*> listed_parameters(const Structure& structure);

}  // namespace eha::ident
