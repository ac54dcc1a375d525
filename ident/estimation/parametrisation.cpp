// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/parametrisation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/error.hpp"

namespace eha::ident {
namespace {

using std::numbers::pi;

// Bounds that no real rig comes near; they keep powers finite.
constexpr double kSlightWeight = 1e-2;    // of a term, against one: below this its coordinate is linear
constexpr double kLeastWeight = 1e-9;     // coordinate; a term of weight 0 would have no order
constexpr double kGreatestWeight = 40.0;  // coordinate
constexpr double kSearchWeight = 12.0;    // where the global search looks
constexpr double kLowestOrder = 0.05;
constexpr double kHighestOrder = 3.0;
constexpr double kWidestDamping = 16.0;  // asinh of the damping ratio
constexpr double kSearchDamping = 4.0;
constexpr double kLongestDelayShare = 0.25;  // of the record
constexpr double kSearchDelaySteps = 40.0;

/// Weight of a denominator term at the reference frequency: proportional to the coordinate where the term hardly
/// matters, so that it can go to nothing and come back, exponential above.
double weight(double x) { return x < 1.0 ? kSlightWeight * x : kSlightWeight * std::exp(x - 1.0); }
double weight_slope(double x) { return x < 1.0 ? kSlightWeight : weight(x); }
double weight_coordinate(double value) {
  const double x = value / kSlightWeight;
  return x < 1.0 ? x : 1.0 + std::log(x);
}

const ParameterRequest* find(const StructureOptions& structure, const std::string& name) {
  for (const ParameterRequest& request : structure.parameters) {
    if (request.name == name) return &request;
  }
  return nullptr;
}

bool is_fixed(const StructureOptions& structure, const std::string& name) {
  const ParameterRequest* request = find(structure, name);
  return request != nullptr && request->fixed.value_or(false);
}

/// A parameter that is constant unless the user says something about it other than its fixed value.
bool is_freed(const StructureOptions& structure, const std::string& name) {
  const ParameterRequest* request = find(structure, name);
  return request != nullptr && !request->fixed.value_or(false) &&
         (request->fixed || request->start || request->lower || request->upper);
}

double requested(const StructureOptions& structure, const std::string& name, double otherwise) {
  const ParameterRequest* request = find(structure, name);
  return request != nullptr && request->start ? *request->start : otherwise;
}

/// Narrows a coordinate to what the user asked for. `scale` turns the user's value into the coordinate's.
void apply(const StructureOptions& structure, Coordinate& coordinate, double (*scale)(double)) {
  const ParameterRequest* request = find(structure, coordinate.name);
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

std::size_t denominator_terms(const StructureOptions& structure) {
  switch (structure.kind) {
    case StructureKind::fo:
      return 3;
    case StructureKind::lag:
      return 2;
    case StructureKind::io:
    case StructureKind::commensurate:
      break;
  }
  return static_cast<std::size_t>(structure.poles) + 1;
}

std::size_t numerator_count(const StructureOptions& structure) {
  const bool polynomial = structure.kind == StructureKind::io || structure.kind == StructureKind::commensurate;
  return polynomial ? static_cast<std::size_t>(structure.zeros) + 1 : 1;
}

void check_requests(const StructureOptions& structure, const std::vector<std::string>& known) {
  for (const ParameterRequest& request : structure.parameters) {
    if (std::find(known.begin(), known.end(), request.name) == known.end()) {
      throw ConfigError(fmt::format("model {}: parameter {}: expected one of {}, got \"{}\"", structure.name,
                                    request.name, fmt::join(known, ", "), request.name));
    }
    if (request.fixed.value_or(false) && !request.start) {
      throw ConfigError(
          fmt::format("model {}: parameter {}: a fixed parameter needs a value", structure.name, request.name));
    }
  }
  if (structure.poles < 1 || structure.poles > 10 || structure.zeros < 0 || structure.zeros > structure.poles) {
    throw ConfigError(fmt::format("model {}: expected 1 to 10 poles and at most as many zeros, got {} and {}",
                                  structure.name, structure.poles, structure.zeros));
  }
}

std::vector<std::string> parameter_names(const StructureOptions& structure) {
  std::vector<std::string> names;
  for (std::size_t i = denominator_terms(structure); i-- > 0;) {
    if (i != 1) names.push_back(coefficient_name(i));
  }
  if (structure.kind == StructureKind::fo) names.insert(names.end(), {"n2", "n1", "b0"});
  if (structure.kind == StructureKind::lag) names.push_back("n1");
  if (structure.kind == StructureKind::commensurate) names.push_back("q");
  for (std::size_t j = 0; j < numerator_count(structure); ++j) {
    names.push_back(numerator_name(j, numerator_count(structure)));
  }
  names.insert(names.end(), {"delay_s", "input_bias", "initial_output"});
  return names;
}

}  // namespace

std::string coefficient_name(std::size_t index) { return "a" + std::to_string(index); }
std::string order_name(std::size_t index) { return "n" + std::to_string(index); }

std::string numerator_name(std::size_t index, std::size_t terms) {
  return terms == 1 ? "K" : "b" + std::to_string(index);
}

std::size_t normalised_term(const TransferFunction& g) { return std::min<std::size_t>(1, g.denominator.size() - 1); }

Parametrisation Parametrisation::search(const StructureOptions& structure, const Scale& scale) {
  check_requests(structure, parameter_names(structure));
  Parametrisation p;
  const double lowest_rad_s = 2.0 * pi / scale.duration_s;
  const double highest_rad_s = 0.25 * pi / scale.step_s;
  p.reference_rad_s_ = std::sqrt(lowest_rad_s * std::max(highest_rad_s, lowest_rad_s));

  const std::size_t terms = denominator_terms(structure);
  bool coefficients_requested = false;
  bool coefficients_limited = false;
  for (std::size_t i = 0; i < terms; ++i) {
    const ParameterRequest* request = find(structure, coefficient_name(i));
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
  for (std::size_t j = 0; j < numerator_count(structure); ++j) {
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
        p.base_.denominator[i].coefficient = *find(structure, name)->start;
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
      const ParameterRequest* request = find(structure, name);
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

std::vector<double> Parametrisation::section_polynomial(const Eigen::VectorXd& theta, std::size_t without) const {
  double q = base_.denominator[1].order;
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    if (coordinates_[l].role == CoordinateRole::base_order) q = theta[static_cast<Eigen::Index>(l)];
  }
  std::vector<double> product = {1.0};
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    if (coordinates_[l].role != CoordinateRole::section_frequency || coordinates_[l].index == without) continue;
    const double radius = std::exp(q * theta[static_cast<Eigen::Index>(l)]);
    std::vector<double> factor = {radius, 1.0};
    if (!(coordinates_[l].index + 1 == sections_ && odd_section_)) {
      factor = {radius * radius, 2.0 * std::sinh(theta[static_cast<Eigen::Index>(l) + 1]) * radius, 1.0};
    }
    std::vector<double> next(product.size() + factor.size() - 1, 0.0);
    for (std::size_t i = 0; i < product.size(); ++i) {
      for (std::size_t j = 0; j < factor.size(); ++j) next[i + j] += product[i] * factor[j];
    }
    product = std::move(next);
  }
  return product;
}

TransferFunction Parametrisation::transfer_function(const Eigen::VectorXd& theta,
                                                    const Eigen::VectorXd& numerator) const {
  TransferFunction g = base_;
  for (Eigen::Index j = 0; j < numerator.size(); ++j)
    g.numerator[static_cast<std::size_t>(j)].coefficient = numerator[j];
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    const Coordinate& c = coordinates_[l];
    const double value = theta[static_cast<Eigen::Index>(l)];
    if (c.role == CoordinateRole::denominator) g.denominator[c.index].coefficient = value;
    if (c.role == CoordinateRole::denominator_order) g.denominator[c.index].order = value;
    if (c.role == CoordinateRole::numerator_order) g.numerator[c.index].order = value;
    if (c.role == CoordinateRole::delay) g.delay_s = value;
    if (c.role == CoordinateRole::base_order) {
      for (std::size_t k = 0; k < g.denominator.size(); ++k) g.denominator[k].order = value * static_cast<double>(k);
      for (std::size_t k = 0; k < g.numerator.size(); ++k) g.numerator[k].order = value * static_cast<double>(k);
    }
  }
  const double log_reference = std::log(reference_rad_s_);
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    const Coordinate& c = coordinates_[l];
    if (c.role != CoordinateRole::weighed_denominator) continue;
    Term& term = g.denominator[c.index];
    const double shift = (g.denominator[1].order - term.order) * log_reference;
    term.coefficient = weight(theta[static_cast<Eigen::Index>(l)]) * std::exp(shift);
  }
  if (sections_ > 0) {
    const std::vector<double> a = section_polynomial(theta, sections_);
    for (std::size_t k = 0; k < a.size(); ++k) g.denominator[k].coefficient = a[k];
  }
  return g;
}

std::vector<Sensitivity> Parametrisation::sensitivities(const Eigen::VectorXd& theta, const TransferFunction& g) const {
  const double log_reference = std::log(reference_rad_s_);
  const double q = g.denominator.size() > 1 ? g.denominator[1].order : 1.0;
  std::vector<bool> weighed(g.denominator.size(), false);
  for (const Coordinate& c : coordinates_) {
    if (c.role == CoordinateRole::weighed_denominator) weighed[c.index] = true;
  }
  // dD by ln of a section's radius and by its damping coordinate, as polynomials in s^q.
  const auto section_change = [&](std::size_t index, std::vector<double> change) {
    const std::vector<double> others = section_polynomial(theta, index);
    std::vector<LogTerm> terms;
    for (std::size_t k = 0; k < others.size() + change.size() - 1; ++k) {
      double sum = 0.0;
      for (std::size_t j = 0; j < change.size(); ++j) {
        if (k >= j && k - j < others.size()) sum += change[j] * others[k - j];
      }
      if (sum != 0.0) terms.push_back({sum, 0.0, g.denominator[k].order});
    }
    return terms;
  };
  const auto radius_change = [&](std::size_t l) {
    const double radius = std::exp(q * theta[static_cast<Eigen::Index>(l)]);
    std::vector<double> change = {radius};
    if (!(coordinates_[l].index + 1 == sections_ && odd_section_)) {
      change = {2.0 * radius * radius, 2.0 * std::sinh(theta[static_cast<Eigen::Index>(l) + 1]) * radius};
    }
    return section_change(coordinates_[l].index, change);
  };

  std::vector<Sensitivity> all;
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    const Coordinate& c = coordinates_[l];
    Sensitivity s;
    switch (c.role) {
      case CoordinateRole::denominator:
        s.denominator.push_back({1.0, 0.0, g.denominator[c.index].order});
        break;
      case CoordinateRole::weighed_denominator: {
        const double x = theta[static_cast<Eigen::Index>(l)];
        const Term& term = g.denominator[c.index];
        s.denominator.push_back({term.coefficient * weight_slope(x) / weight(x), 0.0, term.order});
        break;
      }
      case CoordinateRole::denominator_order: {
        const Term& term = g.denominator[c.index];
        s.denominator.push_back(
            {weighed[c.index] ? -log_reference * term.coefficient : 0.0, term.coefficient, term.order});
        if (c.index != 1) break;
        for (std::size_t k = 0; k < g.denominator.size(); ++k) {
          if (weighed[k])
            s.denominator.push_back({log_reference * g.denominator[k].coefficient, 0.0, g.denominator[k].order});
        }
        break;
      }
      case CoordinateRole::numerator_order:
        s.numerator.push_back({0.0, g.numerator[c.index].coefficient, g.numerator[c.index].order});
        break;
      case CoordinateRole::base_order: {
        for (std::size_t k = 1; k < g.denominator.size(); ++k) {
          const double a = g.denominator[k].coefficient;
          const double shift = weighed[k] ? (1.0 - static_cast<double>(k)) * log_reference * a : 0.0;
          s.denominator.push_back({shift, static_cast<double>(k) * a, g.denominator[k].order});
        }
        if (weighed[0]) s.denominator.push_back({log_reference * g.denominator[0].coefficient, 0.0, 0.0});
        for (std::size_t k = 1; k < g.numerator.size(); ++k) {
          s.numerator.push_back({0.0, static_cast<double>(k) * g.numerator[k].coefficient, g.numerator[k].order});
        }
        for (std::size_t m = 0; m < coordinates_.size(); ++m) {
          if (coordinates_[m].role != CoordinateRole::section_frequency) continue;
          for (LogTerm term : radius_change(m)) {
            term.coefficient *= theta[static_cast<Eigen::Index>(m)];
            s.denominator.push_back(term);
          }
        }
        break;
      }
      case CoordinateRole::section_frequency:
        s.denominator = radius_change(l);
        for (LogTerm& term : s.denominator) term.coefficient *= q;
        break;
      case CoordinateRole::section_damping: {
        const double radius = std::exp(q * theta[static_cast<Eigen::Index>(l) - 1]);
        s.denominator = section_change(c.index, {0.0, 2.0 * radius * std::cosh(theta[static_cast<Eigen::Index>(l)])});
        break;
      }
      case CoordinateRole::delay:
        s.delay = 1.0;
        break;
      case CoordinateRole::input_bias:
        break;
    }
    all.push_back(std::move(s));
  }
  return all;
}

Eigen::VectorXd Parametrisation::with_lower_orders(const Eigen::VectorXd& theta) const {
  Eigen::VectorXd lowered = theta;
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    const CoordinateRole role = coordinates_[l].role;
    if (role == CoordinateRole::denominator_order || role == CoordinateRole::base_order) {
      lowered[static_cast<Eigen::Index>(l)] *= 0.95;
    }
  }
  return lowered;
}

double Parametrisation::input_bias(const Eigen::VectorXd& theta) const {
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    if (coordinates_[l].role == CoordinateRole::input_bias) return theta[static_cast<Eigen::Index>(l)];
  }
  return 0.0;
}

bool Parametrisation::integer_sections() const {
  return sections_ > 0 && std::none_of(coordinates_.begin(), coordinates_.end(),
                                       [](const Coordinate& c) { return c.role == CoordinateRole::base_order; });
}

double Parametrisation::fastest_oscillation(const Eigen::VectorXd& theta) const {
  double fastest = 0.0;
  if (!integer_sections()) return fastest;
  for (std::size_t l = 1; l < coordinates_.size(); ++l) {
    if (coordinates_[l].role != CoordinateRole::section_damping) continue;
    const auto i = static_cast<Eigen::Index>(l);
    const double damping = std::sinh(theta[i]);
    if (damping < 1.0) fastest = std::max(fastest, std::exp(theta[i - 1]) * std::sqrt(1.0 - damping * damping));
  }
  return fastest;
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

Eigen::VectorXd Parametrisation::start() const {
  Eigen::VectorXd v(static_cast<Eigen::Index>(coordinates_.size()));
  for (Eigen::Index l = 0; l < v.size(); ++l) v[l] = coordinates_[static_cast<std::size_t>(l)].start;
  return v;
}

Eigen::VectorXd Parametrisation::lower() const {
  Eigen::VectorXd v(static_cast<Eigen::Index>(coordinates_.size()));
  for (Eigen::Index l = 0; l < v.size(); ++l) v[l] = coordinates_[static_cast<std::size_t>(l)].lower;
  return v;
}

Eigen::VectorXd Parametrisation::upper() const {
  Eigen::VectorXd v(static_cast<Eigen::Index>(coordinates_.size()));
  for (Eigen::Index l = 0; l < v.size(); ++l) v[l] = coordinates_[static_cast<std::size_t>(l)].upper;
  return v;
}

Eigen::VectorXd Parametrisation::leap() const {
  Eigen::VectorXd v(static_cast<Eigen::Index>(coordinates_.size()));
  for (Eigen::Index l = 0; l < v.size(); ++l) {
    const Coordinate& c = coordinates_[static_cast<std::size_t>(l)];
    switch (c.role) {
      case CoordinateRole::weighed_denominator:
      case CoordinateRole::section_frequency:
      case CoordinateRole::section_damping:
        v[l] = 2.0;
        break;
      case CoordinateRole::denominator_order:
      case CoordinateRole::numerator_order:
      case CoordinateRole::base_order:
        v[l] = 0.3;
        break;
      case CoordinateRole::delay:
        v[l] = std::max(c.search_upper - c.search_lower, 1e-300);
        break;
      case CoordinateRole::denominator:
      case CoordinateRole::input_bias:
        v[l] = 1e300;
        break;
    }
  }
  return v;
}

}  // namespace eha::ident
