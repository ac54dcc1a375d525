// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/export/pole_groups.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

constexpr double kNear = 0.3;

/// Converts `numerator` to powers of sigma = s / rate, divided by rate^degree, with exactly `count` coefficients.
std::vector<double> scaled(const Polynomial& numerator, std::size_t count, double rate, std::size_t degree) {
  std::vector<double> out(count, 0.0);
  for (std::size_t i = 0; i < numerator.size(); ++i) {
    const auto power = static_cast<double>(numerator.size() - 1 - i);
    out[count - numerator.size() + i] = numerator[i] * std::pow(rate, power - static_cast<double>(degree));
  }
  return out;
}

}  // namespace

std::vector<std::vector<Complex>> grouped(const std::vector<Complex>& poles) {
  std::vector<std::size_t> group(poles.size());
  std::iota(group.begin(), group.end(), std::size_t{0});
  const auto join = [&](std::size_t a, std::size_t b) {
    const std::size_t from = std::max(group[a], group[b]);
    const std::size_t to = std::min(group[a], group[b]);
    std::replace(group.begin(), group.end(), from, to);
  };
  for (std::size_t i = 0; i < poles.size(); ++i) {
    for (std::size_t j = i + 1; j < poles.size(); ++j) {
      const double size = std::max(std::abs(poles[i]), std::abs(poles[j]));
      const auto near = [&](Complex other) { return std::abs(poles[i] - other) <= kNear * size; };
      if (near(poles[j]) || near(std::conj(poles[j]))) join(i, j);
    }
  }
  std::vector<std::vector<Complex>> groups;
  for (std::size_t g = 0; g < poles.size(); ++g) {
    std::vector<Complex> members;
    for (std::size_t i = 0; i < poles.size(); ++i) {
      if (group[i] == g) members.push_back(poles[i]);
    }
    if (!members.empty()) groups.push_back(std::move(members));
  }
  return groups;
}

Polynomial from_zeros(const std::vector<Complex>& zeros) {
  std::vector<Complex> product{1.0};
  for (const Complex& zero : zeros) {
    product.push_back(0.0);
    for (std::size_t i = product.size() - 1; i > 0; --i) product[i] -= zero * product[i - 1];
  }
  Polynomial real;
  for (const Complex& coefficient : product) real.push_back(coefficient.real());
  return real;
}

Section section_of(const Polynomial& numerator, const Polynomial& denominator, const Polynomial& free_response) {
  const std::size_t n = denominator.size() - 1;
  double rate = 0.0;
  for (std::size_t i = 1; i <= n; ++i) {
    rate = std::max(rate, std::pow(std::abs(denominator[i]), 1.0 / static_cast<double>(i)));
  }
  if (rate <= 0.0) rate = 1.0;  // integrators alone
  Section section;
  section.rate_rad_s = rate;
  section.denominator = scaled(denominator, n + 1, rate, n);
  section.denominator.erase(section.denominator.begin());
  section.numerator = scaled(numerator, n, rate, n);
  section.state = scaled(free_response, n, rate, n);
  for (double& x : section.state) x *= rate;
  return section;
}

}  // namespace eha::ident
