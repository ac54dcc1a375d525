// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/fractional/poles.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ident/fractional/stability.hpp"
#include "ident/linear_algebra/spectra.hpp"

namespace eha::ident {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

constexpr int kHighestDegree = 24;
constexpr double kCoincidentOrders = 1e-9;  // relative distance of two orders that count as one
constexpr double kSamePole = 1e-6;          // distance in ln s of two results that are one pole
constexpr int kMostSteps = 60;
constexpr int kAngles = 13;  // starts between 0 and pi
constexpr int kSizes = 9;    // starts of |s| around each crossing of two terms

/// Newton's step -D / (dD/d ln s) at s = exp(z); the largest term is scaled to 1 against overflow.
Complex newton_step(const std::vector<Term>& terms, Complex z) {
  double largest = -1e300;
  for (const Term& term : terms) {
    largest = std::max(largest, std::log(std::abs(term.coefficient)) + term.order * z.real());
  }
  Complex value = 0.0;
  Complex slope = 0.0;
  for (const Term& term : terms) {
    const double size = std::exp(std::log(std::abs(term.coefficient)) + term.order * z.real() - largest);
    const Complex t = std::copysign(size, term.coefficient) * std::polar(1.0, term.order * z.imag());
    value += t;
    slope += term.order * t;
  }
  return -value / slope;
}

/// Returns the pole that Newton's method finds from z = ln s, with 0 <= arg s <= pi.
std::optional<Complex> pole_from(const std::vector<Term>& terms, Complex z) {
  for (int i = 0; i < kMostSteps; ++i) {
    Complex step = newton_step(terms, z);
    if (!std::isfinite(step.real()) || !std::isfinite(step.imag())) return std::nullopt;
    if (std::abs(step) > 0.5) step *= 0.5 / std::abs(step);
    z += step;
    if (std::abs(step) < 1e-12 * std::max(1.0, std::abs(z))) {
      const bool on_sheet = z.imag() > -kSamePole && z.imag() < pi + kSamePole;
      return on_sheet ? std::optional(Complex(z.real(), std::clamp(z.imag(), 0.0, pi))) : std::nullopt;
    }
  }
  return std::nullopt;
}

/// Returns the sizes ln|s| where two terms are equal: poles are near one of them.
std::vector<double> crossings(const std::vector<Term>& terms) {
  std::vector<double> sizes;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    for (std::size_t j = i + 1; j < terms.size(); ++j) {
      sizes.push_back(std::log(std::abs(terms[i].coefficient / terms[j].coefficient)) /
                      (terms[j].order - terms[i].order));
    }
  }
  return sizes;
}

void add_principal_poles(const ReducedPolynomial& d, Poles& found) {
  const int count = zeros_in_sector(d.terms, pi);
  std::vector<Complex> logarithms;
  int counted = 0;
  for (const double centre : crossings(d.terms)) {
    for (int size = 0; size < kSizes && counted < count; ++size) {
      for (int angle = 0; angle < kAngles; ++angle) {
        const auto pole = pole_from(d.terms, {centre + 0.5 * (size - kSizes / 2), pi * angle / (kAngles - 1)});
        const auto is_same = [&](const Complex& known) { return std::abs(known - *pole) < kSamePole; };
        if (!pole || std::any_of(logarithms.begin(), logarithms.end(), is_same)) continue;
        logarithms.push_back(*pole);
        const Complex s = std::exp(*pole);
        found.values.push_back(s);
        const bool is_real = pole->imag() < kSamePole || pole->imag() > pi - kSamePole;
        if (!is_real) found.values.push_back(std::conj(s));
        counted += is_real ? 1 : 2;
      }
    }
  }
  found.is_complete = counted >= count;
}

}  // namespace

ReducedPolynomial reduced(std::vector<Term> terms) {
  std::erase_if(terms, [](const Term& term) { return term.coefficient == 0.0; });
  std::sort(terms.begin(), terms.end(), [](const Term& a, const Term& b) { return a.order < b.order; });
  ReducedPolynomial out;
  for (const Term& term : terms) {
    if (!out.terms.empty() && term.order - out.terms.back().order <= kCoincidentOrders * std::max(1.0, term.order)) {
      out.terms.back().coefficient += term.coefficient;
    } else {
      out.terms.push_back(term);
    }
  }
  std::erase_if(out.terms, [](const Term& term) { return term.coefficient == 0.0; });
  if (out.terms.empty()) return out;
  out.removed_order = out.terms.front().order;
  for (Term& term : out.terms) term.order -= out.removed_order;
  return out;
}

std::optional<double> base_order(const ReducedPolynomial& polynomial) {
  const double top = polynomial.terms.back().order;
  for (int degree = 1; degree <= kHighestDegree; ++degree) {
    const double q = top / degree;
    const bool fits = std::all_of(polynomial.terms.begin(), polynomial.terms.end(), [&](const Term& term) {
      return std::abs(term.order / q - std::round(term.order / q)) <= kCoincidentOrders * degree;
    });
    if (fits) return q;
  }
  return std::nullopt;
}

std::vector<Complex> commensurate_roots(const ReducedPolynomial& polynomial, double q) {
  const auto degree = static_cast<Eigen::Index>(std::lround(polynomial.terms.back().order / q));
  Eigen::VectorXd a = Eigen::VectorXd::Zero(degree + 1);
  for (const Term& term : polynomial.terms) a[std::lround(term.order / q)] = term.coefficient;
  // Scaling the variable balances the companion matrix: w = s^q / radius.
  const double radius = std::pow(std::abs(a[0] / a[degree]), 1.0 / static_cast<double>(degree));
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(degree, degree);
  for (Eigen::Index k = 0; k < degree; ++k) {
    companion(0, k) = -a[degree - 1 - k] / a[degree] * std::pow(radius, -static_cast<double>(k + 1));
    if (k + 1 < degree) companion(k + 1, k) = 1.0;
  }
  std::vector<Complex> roots;
  const Eigen::VectorXcd scaled = eigenvalues(companion);
  for (const Complex& root : scaled) roots.push_back(radius * root);
  return roots;
}

Poles poles(const TransferFunction& g) {
  const ReducedPolynomial d = reduced(g.denominator);
  Poles found;
  found.order_at_zero = d.removed_order;
  if (d.terms.size() < 2) return found;
  if (const auto q = base_order(d)) {
    found.base_order = *q;
    found.values = commensurate_roots(d, *q);
  } else {
    found.is_commensurate = false;
    add_principal_poles(d, found);
  }
  return found;
}

Poles with_rounded_at_zero(Poles poles) {
  const double q = poles.base_order;
  const auto rounded = std::erase_if(
      poles.values, [&](const Complex& value) { return std::pow(std::abs(value), 1.0 / q) < kSlowestPole_rad_s; });
  poles.order_at_zero += static_cast<double>(rounded) * (poles.is_commensurate ? q : 1.0);
  return poles;
}

}  // namespace eha::ident
