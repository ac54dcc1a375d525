// SPDX-License-Identifier: GPL-3.0-or-later
// The coordinates of a structure, their starts and their bounds.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/error.hpp"
#include "ident/coordinates/parametrisation.hpp"
#include "ident/coordinates/term_weight.hpp"
#include "ident/structure/parameter_requests.hpp"

namespace eha::ident {
namespace {

using std::numbers::pi;

// Bounds far beyond any real rig; they keep powers finite.
constexpr double kLeastWeight = 1e-9;     // coordinate; a term of weight 0 would have no order
constexpr double kGreatestWeight = 40.0;  // coordinate
// The box of the global search.
constexpr double kSearchWeightLow = 0.1;
constexpr double kSearchWeightHigh = 12.0;
constexpr double kWidestFrequency = 15.0;  // ln beyond the search box
constexpr double kSlowerThanRecord = 2.0;  // ln below one period a record
constexpr double kFirstDamping = 0.8;      // asinh of the damping ratio, as are the next ones
constexpr double kWidestDamping = 16.0;
constexpr double kSearchDampingLow = -0.5;
constexpr double kSearchDampingHigh = 4.0;
constexpr double kLeastIntegerDamping = 1e-6;     // a polynomial in s is stable with positive damping alone
constexpr double kLeastFractionalDamping = -1.0;  // one in s^q, q < 1, beyond that
constexpr double kHighestReference = 0.25;        // of the Nyquist frequency
constexpr double kLongestDelayShare = 0.25;       // of the record
constexpr double kSearchDelaySteps = 40.0;
constexpr double kGreatestBias = 1e3;  // times the largest input
constexpr double kUnbounded = 1e300;
constexpr double kFirstDeadBand = 0.03;  // of the input's range

/// Applies the user's requests to a coordinate. `scale` converts the user's value to the coordinate's.
void apply(const ParameterRequest* request, Coordinate& coordinate, double (*scale)(double)) {
  if (request == nullptr) return;
  if (request->lower) coordinate.lower = std::max(coordinate.lower, scale(*request->lower));
  if (request->upper) coordinate.upper = std::min(coordinate.upper, scale(*request->upper));
  if (request->start) coordinate.start = scale(*request->start);
  if (!(coordinate.lower <= coordinate.upper)) {
    throw ConfigError(fmt::format("parameter {}: no value lies between its bounds", coordinate.key.name));
  }
  coordinate.start = std::clamp(coordinate.start, coordinate.lower, coordinate.upper);
  coordinate.search_lower = std::clamp(coordinate.search_lower, coordinate.lower, coordinate.upper);
  coordinate.search_upper = std::clamp(coordinate.search_upper, coordinate.lower, coordinate.upper);
}

double as_is(double value) { return value; }

/// Requests of the user for the denominator's coefficients.
struct CoefficientWishes {
  bool any = false;
  bool limits = false;  ///< a coefficient is held, freed or bounded, not only given a start
};

CoefficientWishes coefficient_wishes(const StructureOptions& asked) {
  CoefficientWishes wishes;
  for (const StructureTerm& term : asked.structure.denominator) {
    const ParameterRequest* request = find_request(asked, term.coefficient);
    if (request == nullptr) continue;
    wishes.any = true;
    wishes.limits = wishes.limits || request->fixed || request->lower || request->upper;
  }
  return wishes;
}

/// Whether a pole is held at 0 and at least two others are free: they may oscillate, which suits sections.
bool has_resonance_beside_integrator(const Structure& structure) {
  const StructureParameter& lowest = structure.denominator.front().coefficient;
  return has_finite_state(structure) && state_count(structure) > 2 && lowest.freedom == Freedom::constant &&
         std::abs(lowest.value) <= 0.0;
}

/// Returns the structure's transfer function at its starts, with estimated coefficients 1.
TransferFunction starting_point(const StructureOptions& asked) {
  const Structure& structure = asked.structure;
  const double q = structure.base_order ? requested(asked, *structure.base_order) : 1.0;
  const auto order = [&](const StructureTerm& term, std::size_t k) {
    return structure.base_order ? q * static_cast<double>(k) : requested(asked, term.order);
  };
  TransferFunction g;
  for (const StructureTerm& term : structure.denominator) {
    const double coefficient = is_estimated(asked, term.coefficient) ? 1.0 : requested(asked, term.coefficient);
    g.denominator.push_back({coefficient, order(term, g.denominator.size())});
  }
  for (const StructureTerm& term : structure.numerator) g.numerator.push_back({1.0, order(term, g.numerator.size())});
  g.delay_s = requested(asked, structure.delay);
  return g;
}

/// The free orders, those of the denominator first, in descending order.
std::vector<std::pair<const StructureParameter*, CoordinateRole>> estimated_orders(const StructureOptions& asked) {
  const Structure& structure = asked.structure;
  std::vector<std::pair<const StructureParameter*, CoordinateRole>> orders;
  for (std::size_t i = structure.denominator.size(); i-- > 0;) {
    orders.emplace_back(&structure.denominator[i].order, CoordinateRole::denominator_order);
  }
  if (structure.base_order) orders.emplace_back(&*structure.base_order, CoordinateRole::base_order);
  for (const StructureTerm& term : structure.numerator) {
    orders.emplace_back(&term.order, CoordinateRole::numerator_order);
  }
  std::erase_if(orders, [&](const auto& order) { return !is_estimated(asked, *order.first); });
  return orders;
}

}  // namespace

void Parametrisation::add_sections(const Structure& structure, const Scale& scale) {
  const std::size_t degree = structure.denominator.size() - (integrates_ ? 2 : 1);
  sections_ = (degree + 1) / 2;
  odd_section_ = degree % 2 == 1;
  const double low = std::log(2.0 * pi / scale.duration_s) - kSlowerThanRecord;
  const double high = std::log(pi / scale.step_s);
  const double least = structure.base_order ? kLeastFractionalDamping : kLeastIntegerDamping;
  for (std::size_t i = 0; i < sections_; ++i) {
    const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(sections_);
    const std::string number = std::to_string(i);
    coordinates_.push_back({{.name = "frequency " + number},
                            CoordinateRole::section_frequency,
                            i,
                            low + share * (high - low),
                            low - kWidestFrequency,
                            high + kWidestFrequency,
                            low,
                            high});
    if (i + 1 == sections_ && odd_section_) continue;
    coordinates_.push_back({{.name = "damping " + number},
                            CoordinateRole::section_damping,
                            i,
                            kFirstDamping,
                            least,
                            kWidestDamping,
                            std::max(least, kSearchDampingLow),
                            kSearchDampingHigh});
  }
}

void Parametrisation::add_weights(const StructureOptions& asked) {
  for (std::size_t i = 0; i < asked.structure.denominator.size(); ++i) {
    const StructureParameter& coefficient = asked.structure.denominator[i].coefficient;
    if (!is_estimated(asked, coefficient)) continue;
    Coordinate coordinate{coefficient.key,
                          CoordinateRole::weighted_denominator,
                          i,
                          weight_coordinate(1.0),
                          kLeastWeight,
                          kGreatestWeight,
                          kSearchWeightLow,
                          kSearchWeightHigh};
    const ParameterRequest* request = find_request(asked, coefficient);
    apply(request, coordinate, weight_coordinate);
    if (request != nullptr && request->start) {
      const double orders = base_.denominator[i].order - base_.denominator[normalised()].order;
      coordinate.start = weight_coordinate(*request->start * std::pow(reference_rad_s_, orders));
    }
    coordinates_.push_back(coordinate);
  }
}

void Parametrisation::add_valve(const StructureOptions& asked, const Scale& scale) {
  const auto& valve = asked.structure.input_map.valve;
  if (!valve) return;
  valve_ = ValveMap{requested(asked, valve->null), requested(asked, valve->dead_band),
                    requested(asked, valve->negative_gain_ratio)};
  const double range = scale.highest_input - scale.lowest_input;
  const auto add = [&](const StructureParameter& parameter, CoordinateRole role, double start, double lower,
                       double upper) {
    if (!is_estimated(asked, parameter)) return;
    Coordinate coordinate{parameter.key, role, 0, start, lower, upper, lower, upper};
    apply(find_request(asked, parameter), coordinate, as_is);
    coordinates_.push_back(std::move(coordinate));
  };
  const double middle = 0.5 * (scale.lowest_input + scale.highest_input);
  add(valve->null, CoordinateRole::valve_null, middle, scale.lowest_input, scale.highest_input);
  const double beside_null = std::max(scale.highest_input - valve_->null, valve_->null - scale.lowest_input);
  const double widest = is_estimated(asked, valve->null) ? 0.5 * range : std::max(0.5 * range, beside_null);
  add(valve->dead_band, CoordinateRole::dead_band, kFirstDeadBand * range, 0.0, widest);
  if (ratio_enters_linearly(asked)) return;
  add(valve->negative_gain_ratio, CoordinateRole::negative_gain_ratio, valve_->negative_gain_ratio, -kUnbounded,
      kUnbounded);
}

Parametrisation Parametrisation::search(const StructureOptions& asked, const Scale& scale) {
  check_requests(asked);
  const Structure& structure = asked.structure;
  Parametrisation p;
  p.strictly_proper_ = ident::must_be_strictly_proper(structure);
  p.base_ = starting_point(asked);
  const double lowest_rad_s = 2.0 * pi / scale.duration_s;
  const double highest_rad_s = kHighestReference * pi / scale.step_s;
  p.reference_rad_s_ = std::sqrt(lowest_rad_s * std::max(highest_rad_s, lowest_rad_s));
  const CoefficientWishes wishes = coefficient_wishes(asked);
  // A coefficient that the user holds or bounds is its own coordinate, independently of the orders.
  if (wishes.limits) p.reference_rad_s_ = 1.0;

  const bool integrates = has_resonance_beside_integrator(structure);
  bool all_free = true;
  for (std::size_t i = integrates ? 1 : 0; i < structure.denominator.size(); ++i) {
    all_free = all_free && (i == p.normalised() || structure.denominator[i].coefficient.freedom == Freedom::free);
  }
  if (has_equal_steps(structure) && all_free && !wishes.any) {
    p.integrates_ = integrates;
    p.add_sections(structure, scale);
  } else {
    p.add_weights(asked);
  }
  for (const auto& [order, role] : estimated_orders(asked)) {
    const double start = requested(asked, *order);
    Coordinate coordinate{order->key,   role,         order->key.index,    start,
                          order->lower, order->upper, order->search_lower, order->search_upper};
    apply(find_request(asked, *order), coordinate, as_is);
    p.coordinates_.push_back(std::move(coordinate));
  }
  if (is_estimated(asked, structure.delay)) {
    const double longest = kLongestDelayShare * scale.duration_s;
    Coordinate coordinate{structure.delay.key,
                          CoordinateRole::delay,
                          0,
                          p.base_.delay_s,
                          0.0,
                          longest,
                          0.0,
                          std::min(longest, kSearchDelaySteps * scale.step_s)};
    apply(find_request(asked, structure.delay), coordinate, as_is);
    p.coordinates_.push_back(std::move(coordinate));
  }
  p.add_valve(asked, scale);
  return p;
}

Parametrisation Parametrisation::plain(const StructureOptions& asked, const TransferFunction& g,
                                       const std::optional<ValveMap>& valve) {
  const Structure& structure = asked.structure;
  Parametrisation p;
  p.strictly_proper_ = ident::must_be_strictly_proper(structure);
  p.base_ = g;
  const auto add = [&](const StructureParameter& parameter, CoordinateRole role, double value) {
    if (!is_estimated(asked, parameter)) return;
    p.coordinates_.push_back(
        {parameter.key, role, parameter.key.index, value, -kUnbounded, kUnbounded, -kUnbounded, kUnbounded});
  };
  for (std::size_t i = g.denominator.size(); i-- > 0;) {
    add(structure.denominator[i].coefficient, CoordinateRole::denominator, g.denominator[i].coefficient);
  }
  for (const auto& [order, role] : estimated_orders(asked)) {
    const double value = role == CoordinateRole::numerator_order ? g.numerator[order->key.index].order
                         : role == CoordinateRole::base_order    ? g.denominator[p.normalised()].order
                                                                 : g.denominator[order->key.index].order;
    add(*order, role, value);
  }
  add(structure.delay, CoordinateRole::delay, g.delay_s);
  p.valve_ = valve;
  if (const auto& map = structure.input_map.valve; map && valve) {
    add(map->null, CoordinateRole::valve_null, valve->null);
    add(map->dead_band, CoordinateRole::dead_band, valve->dead_band);
    add(map->negative_gain_ratio, CoordinateRole::negative_gain_ratio, valve->negative_gain_ratio);
  }
  return p;
}

void Parametrisation::add_input_bias(const StructureOptions& asked, double largest_input, double first_input) {
  const StructureParameter& bias = asked.structure.input_map.bias;
  Coordinate coordinate{bias.key,
                        CoordinateRole::input_bias,
                        0,
                        -first_input,
                        -kGreatestBias * largest_input,
                        kGreatestBias * largest_input,
                        -largest_input,
                        largest_input};
  apply(find_request(asked, bias), coordinate, as_is);
  coordinates_.push_back(std::move(coordinate));
}

}  // namespace eha::ident
