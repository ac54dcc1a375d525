// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/slow_pair.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include "ident/fractional/poles.hpp"
#include "ident/model/engineering_form.hpp"
#include "ident/model/record_start.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::ident {
namespace {

constexpr double kReal = 1e-7;  // imaginary part of a real root, share

/// The greatest time constant of the roots, of a complex one the inverse of its size [s]; 0 without one.
double slowest_s(const std::vector<Term>& terms) {
  const ReducedPolynomial polynomial = reduced(terms);
  if (polynomial.removed_order > 0.0) return std::numeric_limits<double>::infinity();
  if (polynomial.terms.size() < 2) return 0.0;
  double slowest = 0.0;
  for (const std::complex<double>& root : commensurate_roots(polynomial, 1.0)) {
    slowest = std::max(slowest, 1.0 / std::abs(root));
  }
  return slowest;
}

/// Returns the polynomial without its slowest root; nothing without one, or where that is complex. The terms have whole
/// orders.
std::optional<std::vector<Term>> without_slowest_root(const std::vector<Term>& terms) {
  const ReducedPolynomial polynomial = reduced(terms);
  std::vector<Term> rest;
  if (polynomial.removed_order > 0.0) {
    for (const Term& term : polynomial.terms) {
      rest.push_back({term.coefficient, term.order + polynomial.removed_order - 1.0});
    }
    return rest;
  }
  if (polynomial.terms.size() < 2) return {};
  const std::vector<std::complex<double>> roots = commensurate_roots(polynomial, 1.0);
  const auto slowest = std::min_element(roots.begin(), roots.end(),
                                        [](const auto& a, const auto& b) { return std::abs(a) < std::abs(b); });
  if (slowest == roots.end() || !(std::abs(slowest->imag()) < kReal * std::abs(*slowest))) return {};
  const double root = slowest->real();
  const auto degree = static_cast<std::size_t>(std::lround(polynomial.terms.back().order));
  std::vector<double> coefficients(degree + 1, 0.0);
  for (const Term& term : polynomial.terms) {
    coefficients[static_cast<std::size_t>(std::lround(term.order))] = term.coefficient;
  }
  // Division by s - root, from the highest power down.
  double carried = 0.0;
  for (std::size_t power = degree; power > 0; --power) {
    carried = coefficients[power] + root * carried;
    rest.push_back({carried, static_cast<double>(power - 1)});
  }
  return rest;
}

/// The time constants of the real roots of the left half plane [s].
std::vector<double> time_constants_s(const std::vector<Term>& terms) {
  const ReducedPolynomial polynomial = reduced(terms);
  std::vector<double> found;
  if (polynomial.terms.size() < 2) return found;
  for (const std::complex<double>& root : commensurate_roots(polynomial, 1.0)) {
    if (root.real() < 0.0 && std::abs(root.imag()) < kReal * std::abs(root)) found.push_back(-1.0 / root.real());
  }
  return found;
}

}  // namespace

std::optional<PoleAndZero> cancelling_pair(const Model& model) {
  constexpr double kNearly = 1.25;  // of two time constants, the greater over the less
  const TransferFunction& g = model.transfer_function;
  if (model.grey_box || !has_whole_orders(g.numerator) || !has_whole_orders(g.denominator)) return {};
  std::optional<PoleAndZero> found;
  double least = kNearly;
  for (const double pole_s : time_constants_s(g.denominator)) {
    for (const double zero_s : time_constants_s(g.numerator)) {
      const double ratio = std::max(pole_s / zero_s, zero_s / pole_s);
      if (ratio > least) continue;
      least = ratio;
      found = PoleAndZero{pole_s, zero_s};
    }
  }
  return found;
}

std::string cancelling_sentence(const Model& model) {
  const auto pair = cancelling_pair(model);
  if (!pair || takes_in_a_drift(model)) return {};
  const double most = std::max(pair->pole_s / pair->zero_s, pair->zero_s / pair->pole_s) - 1.0;
  return fmt::format(
      "A pole and a zero nearly cancel: T = {:.3g} s and TD = {:.3g} s together change the response by at most {:.2g} "
      "%; take them for a small correction of the fit, not for time constants of the rig.",
      pair->pole_s, pair->zero_s, 100.0 * most);
}

std::optional<Model> without_slow_pair(const Model& model) {
  const TransferFunction& g = model.transfer_function;
  if (model.grey_box || !has_whole_orders(g.numerator) || !has_whole_orders(g.denominator)) return {};
  const auto numerator = without_slowest_root(g.numerator);
  const auto denominator = without_slowest_root(g.denominator);
  if (!numerator || !denominator) return {};
  Model beside;
  beside.transfer_function = {*numerator, *denominator, g.delay_s};
  beside.input_unit = model.input_unit;
  beside.output_unit = model.output_unit;
  return beside;
}

std::string form_without_slow_pair(const Model& model) {
  const std::optional<Model> beside = without_slow_pair(model);
  return beside ? engineering_form(*beside) : std::string();
}

std::optional<double> slow_pair_over_record(const Model& model) {
  const TransferFunction& g = model.transfer_function;
  if (model.grey_box) return {};
  if (!has_whole_orders(g.numerator) || !has_whole_orders(g.denominator)) return {};
  const double record_s = compared_s(model);
  const double pair_s = std::min(slowest_s(g.numerator), slowest_s(g.denominator));
  if (!(pair_s > 0.0) || !std::isfinite(pair_s) || !(record_s > 0.0)) return {};
  return pair_s / record_s;
}

bool takes_in_a_drift(const Verdict& verdict) { return fails_any(verdict, {CriterionKind::slow_pair}); }

bool takes_in_a_drift(const Model& model) { return model.verdict && takes_in_a_drift(*model.verdict); }

}  // namespace eha::ident
