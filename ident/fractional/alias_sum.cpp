// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/fractional/alias_sum.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ident/linear_algebra/spectra.hpp"

namespace eha::ident {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

// Node counts follow from the distance of the nearest singularity, the origin at theta = -2 pi k, on the interval
// [-pi, pi]: the error falls as (2k + sqrt(4k^2 - 1))^-nodes, below 3e-13 for each group.
constexpr std::size_t kFirstNodes = AliasSum::kTerms;
constexpr std::size_t kFurtherNodes = 14;
constexpr std::size_t kTailNodes = 8;
constexpr std::size_t kFurtherAliases = AliasSum::kExplicitAliases - 1;
constexpr double kTailStart = AliasSum::kExplicitAliases + 0.5;
constexpr std::size_t kGaussNodes = 14;

// exp-sinh quadrature of the tail's main integral: r = |p_c| exp(pi/2 sinh t). ln r stays below 50 so that no power
// of it overflows; the integrand falls at least as r^-1.
constexpr double kQuadratureFirst = -3.6;
constexpr double kQuadratureLast = 4.1;
constexpr double kQuadratureStep = 0.2;

struct Rule {
  std::vector<double> node;
  std::vector<double> weight;
};

/// Gauss rule for the weight 1/(2 cosh(pi y)) on [0, inf), by Stieltjes' procedure on a fine discretisation
/// (Gautschi, Orthogonal Polynomials, sec. 2.2) and the eigenvalues of the Jacobi matrix.
Rule gauss_rule() {
  std::vector<double> y;
  std::vector<double> w;
  for (double t = -3.8; t <= 3.2; t += 0.01) {
    const double value = std::exp(t - std::exp(-t));
    y.push_back(value);
    w.push_back(0.01 * value * (1.0 + std::exp(-t)) / (2.0 * std::cosh(pi * value)));
  }
  const auto n = static_cast<Eigen::Index>(kGaussNodes);
  const Eigen::Map<const Eigen::ArrayXd> x(y.data(), static_cast<Eigen::Index>(y.size()));
  const Eigen::Map<const Eigen::ArrayXd> mass(w.data(), static_cast<Eigen::Index>(w.size()));
  Eigen::VectorXd diagonal(n);
  Eigen::VectorXd off(n - 1);
  Eigen::ArrayXd previous = Eigen::ArrayXd::Zero(x.size());
  Eigen::ArrayXd current = Eigen::ArrayXd::Constant(x.size(), 1.0 / std::sqrt(mass.sum()));
  for (Eigen::Index k = 0; k < n; ++k) {
    diagonal[k] = (mass * x * current * current).sum();
    Eigen::ArrayXd next = (x - diagonal[k]) * current;
    if (k > 0) next -= off[k - 1] * previous;
    const double norm = std::sqrt((mass * next * next).sum());
    if (k + 1 < n) off[k] = norm;
    previous = current;
    current = next / norm;
  }
  const SymmetricEigen jacobi = eigen_of_tridiagonal(diagonal, off);
  Rule rule;
  for (Eigen::Index k = 0; k < n; ++k) {
    rule.node.push_back(jacobi.values[k]);
    rule.weight.push_back(mass.sum() * jacobi.vectors(0, k) * jacobi.vectors(0, k));
  }
  return rule;
}

double chebyshev_angle(std::size_t m, std::size_t nodes) {
  return pi * (static_cast<double>(m) + 0.5) / static_cast<double>(nodes);
}

/// The matrix that maps values at Chebyshev nodes to coefficients.
template <std::size_t Nodes>
const Eigen::MatrixXd& chebyshev_transform() {
  static const Eigen::MatrixXd transform = Eigen::MatrixXd::NullaryExpr(
      static_cast<Eigen::Index>(Nodes), static_cast<Eigen::Index>(Nodes), [](Eigen::Index n, Eigen::Index m) {
        return (n == 0 ? 1.0 : 2.0) / static_cast<double>(Nodes) *
               std::cos(static_cast<double>(n) * chebyshev_angle(static_cast<std::size_t>(m), Nodes));
      });
  return transform;
}

/// Adds the Chebyshev coefficients of the values at the nodes to a.
template <std::size_t Nodes>
void add_coefficients(const Eigen::Vector<Complex, Nodes>& values, Eigen::VectorXcd& a) {
  a.head<Nodes>().noalias() += chebyshev_transform<Nodes>() * values;
}

template <std::size_t Used>
double last_coefficients(const Eigen::VectorXcd& a) {
  return a.segment<3>(Used - 3).cwiseAbs().maxCoeff();
}

}  // namespace

AliasSum::Side AliasSum::make_side(double sigma, double step_s, double direction) const {
  static const Rule gauss = gauss_rule();
  Side side;
  const auto add = [&](Complex node, Complex offset, Complex weight) {
    const Complex p = node + offset;
    side.points.add(p.real() / step_s, p.imag() / step_s);
    side.nodes.push_back({offset, weight / p});
  };
  const auto node = [&](std::size_t m, std::size_t nodes) {
    return Complex(sigma, pi * std::cos(chebyshev_angle(m, nodes)));
  };
  for (std::size_t m = 0; m < kFirstNodes; ++m) add(node(m, kFirstNodes), Complex(0.0, 2.0 * pi), 1.0);
  for (std::size_t m = 0; m < kFurtherNodes; ++m) {
    for (std::size_t k = 0; k < kFurtherAliases; ++k) {
      add(node(m, kFurtherNodes), Complex(0.0, 2.0 * pi * static_cast<double>(k + 2)), 1.0);
    }
  }
  const Complex i(0.0, 1.0);
  for (std::size_t m = 0; m < kTailNodes; ++m) {
    const Complex at = node(m, kTailNodes);
    const Complex start(0.0, 2.0 * pi * kTailStart);
    for (double t = kQuadratureFirst; t <= kQuadratureLast; t += kQuadratureStep) {
      const double r = std::abs(start) * std::exp(0.5 * pi * std::sinh(t));
      const double slope = r * 0.5 * pi * std::cosh(t) * kQuadratureStep;
      add(at, start + direction * r, direction * slope / (2.0 * pi * i));
    }
    for (std::size_t j = 0; j < gauss.node.size(); ++j) {
      const double y = gauss.node[j];
      const Complex weight = i * gauss.weight[j] * std::exp(-pi * y);
      add(at, start + 2.0 * pi * y, weight);
      add(at, start - 2.0 * pi * y, -weight);
    }
  }
  return side;
}

AliasSum::AliasSum(double sigma, double step_s)
    : right_(make_side(sigma, step_s, 1.0)), left_(make_side(sigma, step_s, -1.0)) {}

std::vector<AliasSum::Series> AliasSum::evaluate(const TransferColumns& columns, double x, int skip_first) const {
  const Side& side = x < 0.0 ? left_ : right_;
  const std::size_t count = side.nodes.size();
  std::vector<Complex> factor(count);
  for (std::size_t i = 0; i < count; ++i) {
    factor[i] = x == 0.0 ? side.nodes[i].weight : side.nodes[i].weight * std::exp(-x * side.nodes[i].offset);
  }
  std::vector<double> re(count * columns.columns());
  std::vector<double> im(re.size());
  columns.evaluate(side.points, 0, count, re.data(), im.data(), count);

  std::vector<Series> all;
  for (std::size_t c = 0; c < columns.columns(); ++c) {
    const double direct = columns.direct(c);
    std::size_t at = 0;
    const auto next = [&](std::size_t points) {
      Complex sum = 0.0;
      for (const std::size_t end = at + points; at < end; ++at) {
        sum += Complex(re[c * count + at] - direct, im[c * count + at]) * factor[at];
      }
      return sum;
    };
    Eigen::Vector<Complex, kFirstNodes> first;
    Eigen::Vector<Complex, kFurtherNodes> further;
    Eigen::Vector<Complex, kTailNodes> tail;
    for (Complex& value : first) value = next(1);
    for (Complex& value : further) value = next(kFurtherAliases);
    for (Complex& value : tail) value = next((count - kFirstNodes - kFurtherNodes * kFurtherAliases) / kTailNodes);

    Series series;
    Eigen::VectorXcd nearest = Eigen::VectorXcd::Zero(kTerms);
    Eigen::VectorXcd beyond = Eigen::VectorXcd::Zero(kTerms);
    Eigen::VectorXcd sum = Eigen::VectorXcd::Zero(kTerms);
    add_coefficients<kFirstNodes>(first, nearest);
    add_coefficients<kFurtherNodes>(further, beyond);
    add_coefficients<kTailNodes>(tail, sum);
    series.unresolved_first = last_coefficients<kFirstNodes>(nearest);
    series.unresolved_further = last_coefficients<kFurtherNodes>(beyond);
    if (skip_first < 1) sum += nearest;
    if (skip_first < kExplicitAliases) sum += beyond;
    // The aliases -k are the mirror image, so the sum keeps the real part of even and the imaginary part of odd terms.
    series.a.resize(kTerms);
    for (std::size_t n = 0; n < kTerms; ++n) {
      const Complex value = sum[static_cast<Eigen::Index>(n)];
      series.a[n] = 2.0 * (n % 2 == 0 ? value.real() : value.imag());
    }
    all.push_back(std::move(series));
  }
  return all;
}

}  // namespace eha::ident
