// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/export/partial_fractions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>

#include "core/error.hpp"
#include "ident/export/pole_groups.hpp"
#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/linear_algebra/spectra.hpp"

namespace eha::ident {
namespace {

using Complex = std::complex<double>;
using LongComplex = std::complex<long double>;

constexpr double kWholeOrder = 1e-12;
constexpr int kPolishing = 8;         // Newton steps on each pole
constexpr double kAgreement = 1e-11;  // relative error of the sum allowed before the poles are kept in one section

Polynomial polynomial_of(const std::vector<Term>& terms) {
  double degree = 0.0;
  for (const Term& term : terms) {
    if (term.coefficient != 0.0) degree = std::max(degree, term.order);
  }
  Polynomial p(static_cast<std::size_t>(std::lround(degree)) + 1, 0.0);
  for (const Term& term : terms) {
    if (term.coefficient != 0.0)
      p[p.size() - 1 - static_cast<std::size_t>(std::lround(term.order))] += term.coefficient;
  }
  return p;
}

Complex polished(const Polynomial& d, Complex zero) {
  LongComplex z(zero.real(), zero.imag());
  for (int step = 0; step < kPolishing; ++step) {
    LongComplex value = 0.0L;
    LongComplex slope = 0.0L;
    for (const double coefficient : d) {
      slope = slope * z + value;
      value = value * z + static_cast<long double>(coefficient);
    }
    if (std::abs(slope) == 0.0L) break;
    const LongComplex next = z - value / slope;
    if (!(std::abs(next - z) < 0.1L * std::abs(z))) break;  // a multiple zero: the step is of rounding errors
    z = next;
  }
  const Complex result(static_cast<double>(z.real()), static_cast<double>(z.imag()));
  return zero.imag() == 0.0 ? Complex(result.real(), 0.0) : result;
}

/// Zeros of a monic polynomial. Zeros at 0 are exact.
std::vector<Complex> zeros_of(Polynomial d) {
  std::vector<Complex> zeros;
  while (d.size() > 1 && d.back() == 0.0) {
    zeros.emplace_back(0.0);
    d.pop_back();
  }
  const auto n = static_cast<Eigen::Index>(d.size()) - 1;
  if (n == 0) return zeros;
  // Scaling the variable balances the companion matrix.
  const double size = std::pow(std::abs(d.back()), 1.0 / static_cast<double>(n));
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    companion(0, k) = -d[static_cast<std::size_t>(k) + 1] * std::pow(size, -static_cast<double>(k + 1));
    if (k + 1 < n) companion(k + 1, k) = 1.0;
  }
  const Eigen::VectorXcd found = eigenvalues(companion);
  for (const Complex& z : found) {
    if (z.imag() < 0.0) continue;
    const Complex zero = polished(d, z * size);
    zeros.push_back(zero);
    if (z.imag() > 0.0) zeros.push_back(std::conj(zero));
  }
  return zeros;
}

/// a b
Polynomial product(const Polynomial& a, const Polynomial& b) {
  Polynomial p(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) p[i + j] += a[i] * b[j];
  }
  return p;
}

/// The remainder of p by a monic polynomial of degree n, as n coefficients.
Polynomial remainder(Polynomial p, const Polynomial& divisor) {
  const std::size_t n = divisor.size() - 1;
  while (p.size() > n) {
    const double lead = p.front();
    for (std::size_t i = 1; i <= n; ++i) p[i] -= lead * divisor[i];
    p.erase(p.begin());
  }
  p.insert(p.begin(), n - p.size(), 0.0);
  return p;
}

/// Numerators over the group `own`: X with X * (product of the other groups) = p modulo `own`, for each p.
std::vector<Polynomial> numerators_over(const Polynomial& own, const Polynomial& others,
                                        const std::vector<Polynomial>& wanted) {
  const auto n = static_cast<Eigen::Index>(own.size()) - 1;
  Eigen::MatrixXd multiples(n, n);
  Polynomial multiple = remainder(others, own);
  for (Eigen::Index k = n - 1; k >= 0; --k) {
    multiples.col(k) = Eigen::Map<const Eigen::VectorXd>(multiple.data(), n);
    multiple.push_back(0.0);
    multiple = remainder(multiple, own);
  }
  Eigen::MatrixXd right(n, static_cast<Eigen::Index>(wanted.size()));
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const Polynomial rest = remainder(wanted[i], own);
    right.col(static_cast<Eigen::Index>(i)) = Eigen::Map<const Eigen::VectorXd>(rest.data(), n);
  }
  const Eigen::MatrixXd solved = solve_pivoted(multiples, right);
  std::vector<Polynomial> numerators;
  for (Eigen::Index i = 0; i < solved.cols(); ++i) numerators.emplace_back(solved.col(i).begin(), solved.col(i).end());
  return numerators;
}

Polynomial with_scaled_variable(Polynomial p, double scale) {
  for (std::size_t i = 0; i < p.size(); ++i) p[i] *= std::pow(scale, static_cast<double>(p.size() - 1 - i));
  return p;
}

/// The numbers of the section in seconds of `scale`.
void slow_down(Section& section, double scale) {
  section.rate_rad_s *= scale;
  for (double& x : section.state) x *= scale;
}

double disagreement(const Sections& sections, const TransferFunction& g, const std::vector<Complex>& poles) {
  TransferFunction undelayed = g;
  undelayed.delay_s = 0.0;
  double greatest = 0.0;
  for (const Complex& pole : poles) {
    for (const double factor : {0.1, 0.5, 1.3, 8.0}) {
      const Complex s(0.0, factor * (std::abs(pole) > 0.0 ? std::abs(pole) : 1.0));
      const Complex exact = frequency_response(undelayed, s);
      greatest = std::max(greatest, std::abs(frequency_response(sections, s) - exact) / std::abs(exact));
    }
  }
  return greatest;
}

}  // namespace

bool has_whole_orders(const TransferFunction& g) {
  const auto whole = [](const Term& term) {
    return term.coefficient == 0.0 || std::abs(term.order - std::round(term.order)) <= kWholeOrder;
  };
  return std::all_of(g.numerator.begin(), g.numerator.end(), whole) &&
         std::all_of(g.denominator.begin(), g.denominator.end(), whole);
}

Sections partial_fractions(const TransferFunction& g, const std::vector<double>& initial_state) {
  Polynomial d = polynomial_of(g.denominator);
  const double lead = d.front();
  for (double& coefficient : d) coefficient /= lead;
  const std::vector<Complex> poles = zeros_of(d);
  if (initial_state.size() >= d.size()) {
    throw ConfigError(
        fmt::format("initial_state: expected at most {} values beside a denominator of that degree, got {}",
                    d.size() - 1, initial_state.size()));
  }
  // s = scale z keeps the powers of slow and fast poles within the range of numbers.
  double scale = 0.0;
  for (const Complex& pole : poles) scale = std::max(scale, std::abs(pole));
  if (scale <= 0.0) scale = 1.0;
  const double leading = std::pow(scale, static_cast<double>(d.size() - 1));
  const auto prepared = [&](Polynomial p) {
    p = with_scaled_variable(std::move(p), scale);
    for (double& coefficient : p) coefficient /= lead * leading;
    return p;
  };
  Polynomial scaled_d = with_scaled_variable(d, scale);
  for (double& coefficient : scaled_d) coefficient /= leading;
  Polynomial n = prepared(polynomial_of(g.numerator));
  Polynomial free_response = prepared(Polynomial(initial_state.rbegin(), initial_state.rend()));

  Sections result{{}, 0.0, g.delay_s};
  if (n.size() == scaled_d.size()) {
    result.direct = n.front();
    for (std::size_t i = 0; i < n.size(); ++i) n[i] -= result.direct * scaled_d[i];
    n.erase(n.begin());
  }
  if (poles.empty()) return result;

  std::vector<Complex> scaled_poles;
  for (const Complex& pole : poles) scaled_poles.push_back(pole / scale);
  std::vector<Polynomial> groups;
  for (const auto& group : grouped(scaled_poles)) groups.push_back(from_zeros(group));
  Sections separate = result;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    Polynomial others{1.0};
    for (std::size_t j = 0; j < groups.size(); ++j) {
      if (j != i) others = product(others, groups[j]);
    }
    const std::vector<Polynomial> over = numerators_over(groups[i], others, {n, free_response});
    separate.list.push_back(section_of(over[0], groups[i], over[1]));
    slow_down(separate.list.back(), scale);
  }
  Sections together = result;
  together.list.push_back(section_of(n, scaled_d, free_response));
  slow_down(together.list.back(), scale);
  const double apart = disagreement(separate, g, poles);
  return apart <= kAgreement || apart <= disagreement(together, g, poles) ? separate : together;
}

}  // namespace eha::ident
