// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/fractional/stability.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "ident/fractional/poles.hpp"

namespace eha::ident {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

constexpr int kDeepestSplit = 60;
constexpr double kRounding = 1e-15;
constexpr double kAlikeOrders = 0.02;
constexpr double kOutweighed = 0.5;  // sum of the other terms over the dominant group

/// D and s D'/D at s = exp(x + i phi), scaled by the largest term against overflow.
struct Sample {
  double x;
  Complex value;
  Complex slope;
  double noise;  ///< of the value: the rounding error left by terms that cancel
};

Sample sample(const std::vector<Term>& terms, double x, double phi) {
  double largest = -1e300;
  for (const Term& term : terms) largest = std::max(largest, std::log(std::abs(term.coefficient)) + term.order * x);
  Complex value = 0.0;
  Complex slope = 0.0;
  for (const Term& term : terms) {
    const double size = std::log(std::abs(term.coefficient)) + term.order * x - largest;
    const Complex t = std::copysign(std::exp(size), term.coefficient) * std::polar(1.0, term.order * phi);
    value += t;
    slope += term.order * t;
  }
  const double noise = kRounding * (1.0 + terms.back().order * std::abs(x));
  return {x, value, std::abs(value) > 1e-300 ? slope / value : Complex(1e300), noise};
}

/// Whether one order, or a group of almost equal ones, dominates the rest from a to b, and the change of that group's
/// argument. The ratio of two terms is a power of |s|, so it is largest at an end. Such an interval may span many
/// decades.
bool hardly_turns(const std::vector<Term>& terms, const Sample& a, const Sample& b) {
  const auto size = [](const Term& term, double x) { return std::log(std::abs(term.coefficient)) + term.order * x; };
  const Term& largest = *std::max_element(terms.begin(), terms.end(),
                                          [&](const Term& t, const Term& u) { return size(t, a.x) < size(u, a.x); });
  double others = 0.0;
  for (const Term& term : terms) {
    if (std::abs(term.order - largest.order) < kAlikeOrders) continue;
    others +=
        std::exp(std::min(1.0, std::max(size(term, a.x) - size(largest, a.x), size(term, b.x) - size(largest, b.x))));
  }
  if (others > kOutweighed * std::min(std::abs(a.value), std::abs(b.value))) return false;
  // A constant power of s has a constant argument along a ray.
  const double slope = std::max(std::abs(a.slope - largest.order), std::abs(b.slope - largest.order));
  return (b.x - a.x) * slope <= 1.0;
}

double turn(const std::vector<Term>& terms, const Sample& a, const Sample& b, double phi, int depth) {
  // |s D'/D| bounds how fast the argument turns; near a zero at distance d it is 1/d, so an interval that hides a
  // zero is always split.
  if (!((b.x - a.x) * std::max(std::abs(a.slope), std::abs(b.slope)) > 1.0) || depth == kDeepestSplit ||
      hardly_turns(terms, a, b) || std::max(std::abs(a.value), std::abs(b.value)) < std::max(a.noise, b.noise)) {
    return std::arg(b.value / a.value);
  }
  const Sample middle = sample(terms, 0.5 * (a.x + b.x), phi);
  return turn(terms, a, middle, phi, depth + 1) + turn(terms, middle, b, phi, depth + 1);
}

int zeros_in_sector(const ReducedPolynomial& d, double phi) {
  if (d.terms.size() < 2) return 0;
  double low = 1e300;
  double high = -1e300;
  double least_gap = 1e300;
  for (std::size_t i = 0; i < d.terms.size(); ++i) {
    for (std::size_t j = i + 1; j < d.terms.size(); ++j) {
      const double gap = d.terms[j].order - d.terms[i].order;
      const double cross = std::log(std::abs(d.terms[i].coefficient / d.terms[j].coefficient)) / gap;
      low = std::min(low, cross);
      high = std::max(high, cross);
      least_gap = std::min(least_gap, gap);
    }
  }
  // Where one term dominates the rest a hundredfold, the argument is within 0.01 rad of that term's.
  const double margin = std::log(100.0 * static_cast<double>(d.terms.size())) / least_gap;
  const double turned = turn(d.terms, sample(d.terms, low - margin, phi), sample(d.terms, high + margin, phi), phi, 0);
  return static_cast<int>(std::lround((d.terms.back().order * phi - turned) / pi));
}

/// Returns the least |arg s| over the poles on the principal sheet, pi if there is none.
double least_angle_commensurate(const ReducedPolynomial& d, double q) {
  double angle = pi;
  for (const Complex& root : commensurate_roots(d, q)) angle = std::min(angle, std::abs(std::arg(root)) / q);
  return angle;
}

double least_angle_by_winding(const ReducedPolynomial& d) {
  double inside = 0.0;
  double outside = pi;
  if (zeros_in_sector(d, pi) == 0) return pi;
  for (int step = 0; step < 40; ++step) {
    const double middle = 0.5 * (inside + outside);
    (zeros_in_sector(d, middle) == 0 ? inside : outside) = middle;
  }
  return 0.5 * (inside + outside);
}

/// Whether all terms have one sign and lie within a half plane for every s of the closed right half plane; their sum
/// then never vanishes.
bool plainly_stable(const ReducedPolynomial& d) {
  const bool positive =
      std::all_of(d.terms.begin(), d.terms.end(), [](const Term& term) { return term.coefficient > 0.0; });
  return positive && d.terms.back().order < 2.0;
}

/// Whether orders and coefficients are within the range of the tests.
bool decidable(const ReducedPolynomial& d) {
  return std::all_of(d.terms.begin(), d.terms.end(), [&](const Term& term) {
    return std::isfinite(term.coefficient) && std::abs(term.order + d.removed_order) <= kOrderLimit;
  });
}

}  // namespace

int zeros_in_sector(const std::vector<Term>& denominator, double half_angle_rad) {
  return zeros_in_sector(reduced(denominator), half_angle_rad);
}

bool grows(const TransferFunction& g) {
  const ReducedPolynomial d = reduced(g.denominator);
  if (!decidable(d)) return true;
  if (d.terms.size() < 2 || plainly_stable(d)) return false;
  if (const auto q = base_order(d)) {
    // Rounding may put a pole on the imaginary axis to either side of it; such a pole does not grow.
    return least_angle_commensurate(d, *q) < 0.5 * pi - 1e-9;
  }
  return zeros_in_sector(d, 0.5 * pi) > 0;
}

StabilityReport stability(const TransferFunction& g) {
  const ReducedPolynomial d = reduced(g.denominator);
  StabilityReport report;
  report.test = "argument_principle";
  if (!decidable(d)) {
    report.margin_rad = -0.5 * pi;
    return report;
  }
  double angle = pi;
  if (d.terms.size() >= 2) {
    if (const auto q = base_order(d)) {
      report.test = "matignon";
      angle = least_angle_commensurate(d, *q);
    } else {
      angle = least_angle_by_winding(d);
    }
  }
  report.margin_rad = std::min(angle, pi) - 0.5 * pi;
  if (d.removed_order > 0.0) report.margin_rad = std::min(report.margin_rad, 0.0);
  report.stable = report.margin_rad > 1e-9;
  return report;
}

StabilityReport stability_beside_integrator(const TransferFunction& g) {
  const double order = reduced(g.denominator).removed_order - reduced(g.numerator).removed_order;
  if (!(order > 0.0)) return stability(g);
  TransferFunction rest = g;
  for (Term& term : rest.denominator) term.order = std::max(0.0, term.order - order);
  StabilityReport report = stability(rest);
  report.integrator_order = order;
  return report;
}

}  // namespace eha::ident
