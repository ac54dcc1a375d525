// SPDX-License-Identifier: GPL-3.0-or-later
//
// Coordinates of given poles and of given models.
#include <algorithm>
#include <cmath>
#include <limits>

#include "ident/coordinates/parametrisation.hpp"
#include "ident/coordinates/term_weight.hpp"
#include "ident/linear_algebra/spectra.hpp"

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

constexpr double kSameOrder = 1e-9;
// A pole at 0 is placed at this share of the slowest frequency of the search box, a missing one at this multiple of the
// fastest: neither then changes the output of the record noticeably.
constexpr double kStill = 1e-5;
constexpr double kFaster = 1e3;

std::vector<Term> by_rising_order(std::vector<Term> terms) {
  std::stable_sort(terms.begin(), terms.end(), [](const Term& a, const Term& b) { return a.order < b.order; });
  return terms;
}

bool is_same(double a, double b) { return std::abs(a - b) <= kSameOrder * std::max(1.0, std::abs(b)); }

/// Returns the coefficients of D as a polynomial in s^q, the lowest power first and the highest not 0; empty if D is
/// none.
std::vector<double> in_powers(const std::vector<Term>& denominator, double q) {
  std::vector<double> a;
  for (const Term& term : denominator) {
    const double power = std::round(term.order / q);
    if (!is_same(power * q, term.order) || power < 0.0 || power > 100.0) return {};
    const auto k = static_cast<std::size_t>(power);
    a.resize(std::max(a.size(), k + 1), 0.0);
    a[k] += term.coefficient;
  }
  while (!a.empty() && a.back() == 0.0) a.pop_back();
  return a;
}

std::vector<Complex> roots_of(const std::vector<double>& a) {
  const auto degree = static_cast<Eigen::Index>(a.size()) - 1;
  if (degree < 1) return {};
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(degree, degree);
  for (Eigen::Index k = 0; k < degree; ++k) {
    companion(0, k) = -a[static_cast<std::size_t>(degree - 1 - k)] / a.back();
    if (k + 1 < degree) companion(k + 1, k) = 1.0;
  }
  const Eigen::VectorXcd roots = eigenvalues(companion);
  return {roots.begin(), roots.end()};
}

/// Drops the real pole that is nearest to 0. @returns whether there was one
bool drop_slowest_real(std::vector<Complex>& poles) {
  const auto magnitude = [](const Complex& pole) {
    return pole.imag() == 0.0 ? std::abs(pole) : std::numeric_limits<double>::infinity();
  };
  const auto slowest = std::min_element(
      poles.begin(), poles.end(), [&](const Complex& a, const Complex& b) { return magnitude(a) < magnitude(b); });
  if (slowest == poles.end() || slowest->imag() != 0.0) return false;
  poles.erase(slowest);
  return true;
}

}  // namespace

/// @param roots  of the polynomial in s^q, conjugate pairs together, as many as the sections have
void Parametrisation::place_roots(std::vector<Complex> roots, double q, Eigen::VectorXd& theta) const {
  // Oscillating pairs first, then real poles, the fastest last: a section of first order takes the last one.
  std::sort(roots.begin(), roots.end(), [](const Complex& a, const Complex& b) {
    const bool a_real = a.imag() == 0.0;
    const bool b_real = b.imag() == 0.0;
    if (a_real != b_real) return b_real;
    return std::abs(a) < std::abs(b);
  });
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    const Coordinate& c = coordinates_[l];
    if (c.role != CoordinateRole::section_frequency) continue;
    const auto i = static_cast<Eigen::Index>(l);
    const Complex first = roots[2 * c.index];
    if (c.index + 1 == sections_ && odd_section_) {
      theta[i] = std::log(std::abs(first)) / q;
      continue;
    }
    const Complex second = first.imag() == 0.0 ? roots[2 * c.index + 1] : std::conj(first);
    const double radius = std::sqrt(std::abs(first) * std::abs(second));
    theta[i] = std::log(radius) / q;
    theta[i + 1] = std::asinh(-(first + second).real() / (2.0 * radius));
  }
}

std::optional<Eigen::VectorXd> Parametrisation::at_poles(std::vector<Complex> poles, double delay_s) const {
  if (!integer_sections() || poles.size() + 1 != base_.denominator.size()) return {};
  if (integrates_ && !drop_slowest_real(poles)) return {};
  Eigen::VectorXd theta = start();
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    if (coordinates_[l].role != CoordinateRole::delay) continue;
    if (delay_s > coordinates_[l].search_upper) return {};
    theta[static_cast<Eigen::Index>(l)] = delay_s;
  }
  place_roots(std::move(poles), 1.0, theta);
  return theta.cwiseMax(lower()).cwiseMin(upper());
}

/// Places a model in sections: D is a polynomial in s^q. @returns whether the denominator is one of at most that degree
bool Parametrisation::place_polynomial(const std::vector<Term>& denominator, Eigen::VectorXd& theta) const {
  double q = 1.0;
  const Coordinate* base_order = nullptr;
  const Coordinate* frequency = nullptr;
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    const Coordinate& c = coordinates_[l];
    if (c.role == CoordinateRole::section_frequency) frequency = &c;
    if (c.role != CoordinateRole::base_order) continue;
    base_order = &c;
    // A model of integer orders is a polynomial in s; with another base order its second term has order q.
    if (in_powers(denominator, 1.0).empty() && denominator.size() > 1) q = denominator[1].order;
    if (!(q >= c.lower && q <= c.upper)) return false;
    theta[static_cast<Eigen::Index>(l)] = q;
  }
  if (base_order == nullptr && !integer_sections()) return false;
  if (base_order == nullptr) q = base_.denominator[normalised()].order;
  std::vector<double> a = in_powers(denominator, q);
  if (a.size() < 2 || a.size() > base_.denominator.size() || frequency == nullptr) return false;
  if (integrates_ && std::abs(a.front()) > 0.0) return false;
  if (integrates_) a.erase(a.begin());
  const std::size_t degree = base_.denominator.size() - (integrates_ ? 2 : 1);
  std::vector<Complex> roots = roots_of(a);
  const double slowest = std::pow(kStill * std::exp(frequency->search_lower), q);
  for (Complex& root : roots) {
    if (std::abs(root) < slowest) root = -slowest;
  }
  double fastest = kFaster * std::exp(frequency->search_upper);
  while (roots.size() < degree) {
    roots.emplace_back(-std::pow(fastest, q));
    fastest *= kFaster;
  }
  place_roots(std::move(roots), q, theta);
  return true;
}

/// Places coefficients and orders as coordinates: finds a place for each term of the denominator, in their order.
bool Parametrisation::place_terms(const std::vector<Term>& denominator, Eigen::VectorXd& theta) const {
  const std::size_t places = base_.denominator.size();
  std::vector<const Coordinate*> order_at(places, nullptr);
  std::vector<const Coordinate*> weight_at(places, nullptr);
  for (const Coordinate& c : coordinates_) {
    if (c.role == CoordinateRole::denominator_order) order_at[c.index] = &c;
    if (c.role == CoordinateRole::weighted_denominator) weight_at[c.index] = &c;
    if (c.role == CoordinateRole::base_order) return false;
  }
  if (denominator.size() > places) return false;
  const auto fits = [&](std::size_t place, const Term& term) {
    if (order_at[place] == nullptr) return is_same(term.order, base_.denominator[place].order);
    return term.order >= order_at[place]->lower && term.order <= order_at[place]->upper;
  };
  // Picks the selection of places in which every term fits that is nearest to the orders' starts.
  std::vector<bool> taken(places, false);
  std::fill(taken.begin(), taken.begin() + static_cast<std::ptrdiff_t>(denominator.size()), true);
  std::vector<bool> chosen;
  double nearest = std::numeric_limits<double>::infinity();
  do {
    double distance = 0.0;
    std::size_t next = 0;
    for (std::size_t place = 0; place < places; ++place) {
      if (!taken[place]) continue;
      const Term& term = denominator[next++];
      if (!fits(place, term) || (place == normalised() && term.coefficient == 0.0)) distance = nearest;
      distance += std::abs(term.order - base_.denominator[place].order);
    }
    if (taken[normalised()] && distance < nearest) {
      nearest = distance;
      chosen = taken;
    }
  } while (std::prev_permutation(taken.begin(), taken.end()));
  if (chosen.empty()) return false;

  std::vector<const Term*> term_at(places, nullptr);
  std::size_t next = 0;
  for (std::size_t place = 0; place < places; ++place) {
    if (chosen[place]) term_at[place] = &denominator[next++];
  }
  const Term& scale = *term_at[normalised()];
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    const Coordinate& c = coordinates_[l];
    double& value = theta[static_cast<Eigen::Index>(l)];
    const bool is_weight = c.role == CoordinateRole::weighted_denominator;
    if (!is_weight && c.role != CoordinateRole::denominator_order) continue;
    const Term* term = term_at[c.index];
    if (!is_weight) {
      if (term != nullptr) value = term->order;
      continue;
    }
    const double coefficient = term == nullptr ? 0.0 : term->coefficient / scale.coefficient;
    if (coefficient < 0.0) return false;
    const double order = term == nullptr ? scale.order : term->order;
    value = weight_coordinate(coefficient * std::pow(reference_rad_s_, order - scale.order));
  }
  return true;
}

/// Places the orders of the numerator. @returns whether there is a place for each of its terms
bool Parametrisation::place_numerator(std::vector<Term> numerator, Eigen::VectorXd& theta) const {
  if (numerator.size() > base_.numerator.size()) return false;
  numerator = by_rising_order(std::move(numerator));
  for (std::size_t j = 0; j < numerator.size(); ++j) {
    const Coordinate* order = nullptr;
    std::size_t at = 0;
    bool is_in_powers = false;
    for (std::size_t l = 0; l < coordinates_.size(); ++l) {
      is_in_powers = is_in_powers || coordinates_[l].role == CoordinateRole::base_order;
      if (coordinates_[l].role != CoordinateRole::numerator_order || coordinates_[l].index != j) continue;
      order = &coordinates_[l];
      at = l;
    }
    if (order != nullptr) {
      if (!(numerator[j].order >= order->lower && numerator[j].order <= order->upper)) return false;
      theta[static_cast<Eigen::Index>(at)] = numerator[j].order;
    } else if (!is_in_powers && !is_same(numerator[j].order, base_.numerator[j].order)) {
      return false;
    }
  }
  return true;
}

std::optional<Eigen::VectorXd> Parametrisation::at_model(const TransferFunction& g, double bias,
                                                         const std::optional<ValveMap>& map) const {
  if (map && !valve_) return {};
  Eigen::VectorXd theta = start();
  bool has_delay = false;
  for (std::size_t l = 0; l < coordinates_.size(); ++l) {
    double& value = theta[static_cast<Eigen::Index>(l)];
    switch (coordinates_[l].role) {
      case CoordinateRole::delay:
        has_delay = true;
        value = g.delay_s;
        break;
      case CoordinateRole::input_bias:
        value = bias;
        break;
      case CoordinateRole::valve_null:
        value = map ? map->null : -bias;
        break;
      case CoordinateRole::dead_band:
        value = map ? map->dead_band : 0.0;
        break;
      case CoordinateRole::negative_gain_ratio:
        value = map ? map->negative_gain_ratio : 1.0;
        break;
      default:
        break;
    }
  }
  if (!has_delay && !is_same(g.delay_s, base_.delay_s)) return {};
  const std::vector<Term> denominator = by_rising_order(g.denominator);
  if (!place_numerator(g.numerator, theta)) return {};
  if (!(sections_ > 0 ? place_polynomial(denominator, theta) : place_terms(denominator, theta))) return {};
  if (!theta.allFinite()) return {};
  return theta.cwiseMax(lower()).cwiseMin(upper());
}

}  // namespace eha::ident
