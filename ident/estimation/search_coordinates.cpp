// SPDX-License-Identifier: GPL-3.0-or-later
// Which coordinates a structure has, where they start and how far they reach.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "ident/estimation/parametrisation.hpp"
#include "ident/estimation/term_weight.hpp"

namespace eha::ident {
namespace {

using std::numbers::pi;

// Bounds that no real rig comes near; they keep powers finite.
constexpr double kLeastWeight = 1e-9;     // coordinate; a term of weight 0 would have no order
constexpr double kGreatestWeight = 40.0;  // coordinate
constexpr double kSearchWeight = 12.0;    // where the global search looks
constexpr double kLowestOrder = 0.05;
constexpr double kHighestOrder = 3.0;
constexpr double kWidestDamping = 16.0;  // asinh of the damping ratio
constexpr double kSearchDamping = 4.0;
constexpr double kLongestDelayShare = 0.25;  // of the record
constexpr double kSearchDelaySteps = 40.0;

/// Narrows a coordinate to what the user asked for. `scale` turns the user's value into the coordinate's.
void apply(const StructureOptions& structure, Coordinate& coordinate, double (*scale)(double)) {
  const ParameterRequest* request = find_request(structure, coordinate.name);
  if (request == nullptr) return;
  if (request->lower) coordinate.lower = std::max(coordinate.lower, scale(*request->lower));
  if (request->upper) coordinate.upper = std::min(coordinate.upper, scale(*request->upper));
  if (request->start) coordinate.start = scale(*request->start);
  if (!(coordinate.lower <= coordinate.upper)) {
    throw ConfigError(fmt::format("parameter {}: no value lies between its bounds", coordinate.name));
  }
  coordinate.start = std::clamp(coordinate.start, coordinate.lower, coordinate.upper);
  coordinate.search_lower = std::clamp(coordinate.search_lower, coordinate.lower, coordinate.upper);
  coordinate.search_upper = std::clamp(coordinate.search_upper, coordinate.lower, coordinate.upper);
}

double as_is(double value) { return value; }

}  // namespace

Parametrisation Parametrisation::search(const StructureOptions& structure, const Scale& scale) {
  check_requests(structure);
  Parametrisation p;
  const double lowest_rad_s = 2.0 * pi / scale.duration_s;
  const double highest_rad_s = 0.25 * pi / scale.step_s;
  p.reference_rad_s_ = std::sqrt(lowest_rad_s * std::max(highest_rad_s, lowest_rad_s));

  const std::size_t terms = denominator_terms(structure);
  bool coefficients_requested = false;
  bool coefficients_limited = false;
  for (std::size_t i = 0; i < terms; ++i) {
    const ParameterRequest* request = find_request(structure, coefficient_name(i));
    if (request == nullptr) continue;
    coefficients_requested = true;
    coefficients_limited = coefficients_limited || request->fixed || request->lower || request->upper;
  }
  const bool polynomial = structure.kind == StructureKind::io || structure.kind == StructureKind::commensurate;
  // A coefficient that the user holds or bounds is a coordinate of its own, whatever the orders.
  if (coefficients_limited) p.reference_rad_s_ = 1.0;

  double q = 1.0;
  if (structure.kind == StructureKind::commensurate) q = requested(structure, "q", 0.9);
  const double order2 = requested(structure, "n2", 1.8);
  const double order1 = requested(structure, "n1", 0.9);
  for (std::size_t i = 0; i < terms; ++i) {
    double order = q * static_cast<double>(i);
    if (!polynomial) order = i == 0 ? 0.0 : (i == 1 ? order1 : order2);
    p.base_.denominator.push_back({1.0, order});
  }
  for (std::size_t j = 0; j < ident::numerator_terms(structure); ++j) {
    p.base_.numerator.push_back({1.0, polynomial ? q * static_cast<double>(j) : requested(structure, "b0", 0.0)});
  }
  p.base_.delay_s = requested(structure, "delay_s", structure.delay_s);

  if (polynomial && !coefficients_requested) {
    p.sections_ = terms / 2;
    p.odd_section_ = (terms - 1) % 2 == 1;
    const double low = std::log(lowest_rad_s) - 2.0;
    const double high = std::log(pi / scale.step_s);
    for (std::size_t i = 0; i < p.sections_; ++i) {
      const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(p.sections_);
      const std::string number = std::to_string(i);
      p.coordinates_.push_back({"frequency " + number, CoordinateRole::section_frequency, i, low + share * (high - low),
                                low - 15.0, high + 15.0, low, high});
      if (i + 1 == p.sections_ && p.odd_section_) continue;
      const double least = structure.kind == StructureKind::io ? 1e-6 : -1.0;
      p.coordinates_.push_back({"damping " + number, CoordinateRole::section_damping, i, 0.8, least, kWidestDamping,
                                std::max(least, -0.5), kSearchDamping});
    }
  } else {
    for (std::size_t i = 0; i < terms; ++i) {
      if (i == 1) continue;
      const std::string name = coefficient_name(i);
      if (is_fixed(structure, name)) {
        p.base_.denominator[i].coefficient = *find_request(structure, name)->start;
        continue;
      }
      Coordinate coordinate{name,
                            CoordinateRole::weighed_denominator,
                            i,
                            weight_coordinate(1.0),
                            kLeastWeight,
                            kGreatestWeight,
                            0.1,
                            kSearchWeight};
      apply(structure, coordinate, weight_coordinate);
      const ParameterRequest* request = find_request(structure, name);
      if (request != nullptr && request->start) {
        const double orders = p.base_.denominator[i].order - p.base_.denominator[1].order;
        coordinate.start = weight_coordinate(*request->start * std::pow(p.reference_rad_s_, orders));
      }
      p.coordinates_.push_back(coordinate);
    }
  }
  const auto add = [&](Coordinate coordinate) {
    if (is_fixed(structure, coordinate.name)) return;
    apply(structure, coordinate, as_is);
    p.coordinates_.push_back(std::move(coordinate));
  };
  if (structure.kind == StructureKind::fo) {
    add({"n2", CoordinateRole::denominator_order, 2, order2, kLowestOrder, kHighestOrder, 1.2, 2.2});
  }
  if (!polynomial) {
    add({"n1", CoordinateRole::denominator_order, 1, order1, kLowestOrder, kHighestOrder, 0.3, 1.2});
  }
  if (structure.kind == StructureKind::commensurate) {
    add({"q", CoordinateRole::base_order, 0, q, kLowestOrder, 1.99, 0.4, 1.2});
  }
  if (structure.kind == StructureKind::fo && is_freed(structure, "b0")) {
    add({"b0", CoordinateRole::numerator_order, 0, p.base_.numerator[0].order, 0.0, kHighestOrder, 0.0, 0.6});
  }
  if (structure.delay_free || is_freed(structure, "delay_s")) {
    const double longest = kLongestDelayShare * scale.duration_s;
    add({"delay_s", CoordinateRole::delay, 0, p.base_.delay_s, 0.0, longest, 0.0,
         std::min(longest, kSearchDelaySteps * scale.step_s)});
  }
  return p;
}

Parametrisation Parametrisation::plain(const StructureOptions& structure, const TransferFunction& g) {
  Parametrisation p;
  p.base_ = g;
  const auto add = [&](const std::string& name, CoordinateRole role, std::size_t index, double value) {
    if (is_fixed(structure, name)) return;
    p.coordinates_.push_back({name, role, index, value, -1e300, 1e300, -1e300, 1e300});
  };
  for (std::size_t i = g.denominator.size(); i-- > 0;) {
    if (i != normalised_term(g)) add(coefficient_name(i), CoordinateRole::denominator, i, g.denominator[i].coefficient);
  }
  if (structure.kind == StructureKind::fo) add("n2", CoordinateRole::denominator_order, 2, g.denominator[2].order);
  if (structure.kind == StructureKind::fo || structure.kind == StructureKind::lag) {
    add("n1", CoordinateRole::denominator_order, 1, g.denominator[1].order);
  }
  if (structure.kind == StructureKind::commensurate) add("q", CoordinateRole::base_order, 0, g.denominator[1].order);
  if (structure.kind == StructureKind::fo && is_freed(structure, "b0")) {
    add("b0", CoordinateRole::numerator_order, 0, g.numerator[0].order);
  }
  if (structure.delay_free || is_freed(structure, "delay_s")) add("delay_s", CoordinateRole::delay, 0, g.delay_s);
  return p;
}

void Parametrisation::add_input_bias(const StructureOptions& structure, double largest_input, double first_input) {
  Coordinate coordinate{"input_bias",
                        CoordinateRole::input_bias,
                        0,
                        -first_input,
                        -1e3 * largest_input,
                        1e3 * largest_input,
                        -largest_input,
                        largest_input};
  apply(structure, coordinate, as_is);
  coordinates_.push_back(std::move(coordinate));
}

std::optional<Eigen::VectorXd> Parametrisation::at_poles(std::vector<std::complex<double>> poles,
                                                         double delay_s) const {
  if (!integer_sections() || poles.size() + 1 != base_.denominator.size()) return {};
  // Oscillating pairs first, then real poles, the fastest last: it is the one a section of first order takes.
  std::sort(poles.begin(), poles.end(), [](const std::complex<double>& a, const std::complex<double>& b) {
    const bool a_real = a.imag() == 0.0;
    const bool b_real = b.imag() == 0.0;
    if (a_real != b_real) return b_real;
    return std::abs(a) < std::abs(b);
  });
  Eigen::VectorXd theta = start();
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    const Coordinate& c = coordinates_[l];
    const auto i = static_cast<Eigen::Index>(l);
    if (c.role == CoordinateRole::delay) {
      if (delay_s > c.search_upper) return {};
      theta[i] = delay_s;
    }
    if (c.role != CoordinateRole::section_frequency) continue;
    const std::complex<double> first = poles[2 * c.index];
    if (c.index + 1 == sections_ && odd_section_) {
      theta[i] = std::log(std::abs(first));
      continue;
    }
    const std::complex<double> second = first.imag() == 0.0 ? poles[2 * c.index + 1] : std::conj(first);
    const double frequency = std::sqrt(std::abs(first) * std::abs(second));
    theta[i] = std::log(frequency);
    theta[i + 1] = std::asinh(-(first + second).real() / (2.0 * frequency));
  }
  return theta.cwiseMax(lower()).cwiseMin(upper());
}

}  // namespace eha::ident
