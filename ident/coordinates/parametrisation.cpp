// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/coordinates/parametrisation.hpp"

#include <algorithm>
#include <cmath>

#include "ident/coordinates/term_weight.hpp"

namespace eha::ident {

namespace {

// Largest change of a coordinate in one step.
constexpr double kWeightStep = 2.0;  // of a logarithm
constexpr double kOrderStep = 0.3;
constexpr double kLeastStep = 1e-300;   // not 0
constexpr double kAnyStep = 1e300;      // linear enough
constexpr double kLoweredOrder = 0.95;  // share of an order in with_lower_orders()

}  // namespace

std::vector<double> Parametrisation::section_polynomial(const Eigen::VectorXd& theta, std::size_t without) const {
  double q = base_.denominator[normalised()].order;
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
  if (integrates_) product.insert(product.begin(), 0.0);
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
    if (c.role != CoordinateRole::weighted_denominator) continue;
    Term& term = g.denominator[c.index];
    const double shift = (g.denominator[normalised()].order - term.order) * log_reference;
    term.coefficient = weight(theta[static_cast<Eigen::Index>(l)]) * std::exp(shift);
  }
  if (sections_ > 0) {
    const std::vector<double> a = section_polynomial(theta, sections_);
    for (std::size_t k = 0; k < a.size(); ++k) g.denominator[k].coefficient = a[k];
  }
  return g;
}

std::vector<bool> Parametrisation::weighted_terms() const {
  std::vector<bool> weighted(base_.denominator.size(), false);
  for (const Coordinate& c : coordinates_) {
    if (c.role == CoordinateRole::weighted_denominator) weighted[c.index] = true;
  }
  return weighted;
}

/// dD of a change of one section, as a polynomial in s^q.
std::vector<LogTerm> Parametrisation::section_change(const Eigen::VectorXd& theta, const TransferFunction& g,
                                                     std::size_t section, const std::vector<double>& change) const {
  const std::vector<double> others = section_polynomial(theta, section);
  std::vector<LogTerm> terms;
  for (std::size_t k = 0; k < others.size() + change.size() - 1; ++k) {
    double sum = 0.0;
    for (std::size_t j = 0; j < change.size(); ++j) {
      if (k >= j && k - j < others.size()) sum += change[j] * others[k - j];
    }
    if (sum != 0.0) terms.push_back({sum, 0.0, g.denominator[k].order});
  }
  return terms;
}

/// dD by ln of the radius of the section whose frequency is this coordinate.
std::vector<LogTerm> Parametrisation::radius_change(const Eigen::VectorXd& theta, const TransferFunction& g,
                                                    std::size_t coordinate) const {
  const double q = g.denominator[normalised()].order;
  const double radius = std::exp(q * theta[static_cast<Eigen::Index>(coordinate)]);
  const std::size_t section = coordinates_[coordinate].index;
  std::vector<double> change = {radius};
  if (!(section + 1 == sections_ && odd_section_)) {
    const double damping = std::sinh(theta[static_cast<Eigen::Index>(coordinate) + 1]);
    change = {2.0 * radius * radius, 2.0 * damping * radius};
  }
  return section_change(theta, g, section, change);
}

Sensitivity Parametrisation::by_denominator_order(const TransferFunction& g, std::size_t index) const {
  const double log_reference = std::log(reference_rad_s_);
  const std::vector<bool> weighted = weighted_terms();
  const Term& term = g.denominator[index];
  Sensitivity s;
  s.denominator.push_back({weighted[index] ? -log_reference * term.coefficient : 0.0, term.coefficient, term.order});
  if (index != normalised()) return s;
  // The weights are relative to the normalised term, whose order moves them all.
  for (std::size_t k = 0; k < g.denominator.size(); ++k) {
    if (weighted[k])
      s.denominator.push_back({log_reference * g.denominator[k].coefficient, 0.0, g.denominator[k].order});
  }
  return s;
}

Sensitivity Parametrisation::by_base_order(const Eigen::VectorXd& theta, const TransferFunction& g) const {
  const double log_reference = std::log(reference_rad_s_);
  const std::vector<bool> weighted = weighted_terms();
  Sensitivity s;
  for (std::size_t k = 1; k < g.denominator.size(); ++k) {
    const double a = g.denominator[k].coefficient;
    const double shift = weighted[k] ? (1.0 - static_cast<double>(k)) * log_reference * a : 0.0;
    s.denominator.push_back({shift, static_cast<double>(k) * a, g.denominator[k].order});
  }
  if (weighted[0]) s.denominator.push_back({log_reference * g.denominator[0].coefficient, 0.0, 0.0});
  for (std::size_t k = 1; k < g.numerator.size(); ++k) {
    s.numerator.push_back({0.0, static_cast<double>(k) * g.numerator[k].coefficient, g.numerator[k].order});
  }
  for (std::size_t m = 0; m < coordinates_.size(); ++m) {
    if (coordinates_[m].role != CoordinateRole::section_frequency) continue;
    for (LogTerm term : radius_change(theta, g, m)) {
      term.coefficient *= theta[static_cast<Eigen::Index>(m)];
      s.denominator.push_back(term);
    }
  }
  return s;
}

std::vector<Sensitivity> Parametrisation::sensitivities(const Eigen::VectorXd& theta, const TransferFunction& g) const {
  const double q = g.denominator[normalised()].order;
  std::vector<Sensitivity> all;
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    const Coordinate& c = coordinates_[l];
    const double x = theta[static_cast<Eigen::Index>(l)];
    Sensitivity s;
    switch (c.role) {
      case CoordinateRole::denominator:
        s.denominator.push_back({1.0, 0.0, g.denominator[c.index].order});
        break;
      case CoordinateRole::weighted_denominator: {
        const Term& term = g.denominator[c.index];
        s.denominator.push_back({term.coefficient * weight_slope(x) / weight(x), 0.0, term.order});
        break;
      }
      case CoordinateRole::denominator_order:
        s = by_denominator_order(g, c.index);
        break;
      case CoordinateRole::numerator_order:
        s.numerator.push_back({0.0, g.numerator[c.index].coefficient, g.numerator[c.index].order});
        break;
      case CoordinateRole::base_order:
        s = by_base_order(theta, g);
        break;
      case CoordinateRole::section_frequency:
        s.denominator = radius_change(theta, g, l);
        for (LogTerm& term : s.denominator) term.coefficient *= q;
        break;
      case CoordinateRole::section_damping: {
        const double radius = std::exp(q * theta[static_cast<Eigen::Index>(l) - 1]);
        s.denominator = section_change(theta, g, c.index, {0.0, 2.0 * radius * std::cosh(x)});
        break;
      }
      case CoordinateRole::delay:
        s.delay = 1.0;
        break;
      case CoordinateRole::input_bias:
      case CoordinateRole::valve_null:
      case CoordinateRole::dead_band:
      case CoordinateRole::negative_gain_ratio:
        break;
    }
    all.push_back(std::move(s));
  }
  return all;
}

std::ptrdiff_t Parametrisation::weight_count() const {
  return std::count_if(coordinates_.begin(), coordinates_.end(),
                       [](const Coordinate& c) { return c.role == CoordinateRole::weighted_denominator; });
}

Eigen::VectorXd Parametrisation::with_lower_orders(const Eigen::VectorXd& theta) const {
  Eigen::VectorXd lowered = theta;
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    const CoordinateRole role = coordinates_[l].role;
    if (role == CoordinateRole::denominator_order || role == CoordinateRole::base_order) {
      lowered[static_cast<Eigen::Index>(l)] *= kLoweredOrder;
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

std::optional<ValveMap> Parametrisation::valve(const Eigen::VectorXd& theta) const {
  if (!valve_) return {};
  ValveMap map = *valve_;
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    const double value = theta[static_cast<Eigen::Index>(l)];
    if (coordinates_[l].role == CoordinateRole::valve_null) map.null = value;
    if (coordinates_[l].role == CoordinateRole::dead_band) map.dead_band = value;
    if (coordinates_[l].role == CoordinateRole::negative_gain_ratio) map.negative_gain_ratio = value;
  }
  return map;
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

Eigen::VectorXd Parametrisation::max_step() const {
  Eigen::VectorXd v(static_cast<Eigen::Index>(coordinates_.size()));
  for (Eigen::Index l = 0; l < v.size(); ++l) {
    const Coordinate& c = coordinates_[static_cast<std::size_t>(l)];
    switch (c.role) {
      case CoordinateRole::weighted_denominator:
      case CoordinateRole::section_frequency:
      case CoordinateRole::section_damping:
        v[l] = kWeightStep;
        break;
      case CoordinateRole::denominator_order:
      case CoordinateRole::numerator_order:
      case CoordinateRole::base_order:
        v[l] = kOrderStep;
        break;
      case CoordinateRole::delay:
        v[l] = std::max(c.search_upper - c.search_lower, kLeastStep);
        break;
      case CoordinateRole::denominator:
      case CoordinateRole::input_bias:
      case CoordinateRole::valve_null:
      case CoordinateRole::dead_band:
      case CoordinateRole::negative_gain_ratio:
        v[l] = kAnyStep;
        break;
    }
  }
  return v;
}

}  // namespace eha::ident
