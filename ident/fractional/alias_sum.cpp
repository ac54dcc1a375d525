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

constexpr std::size_t kFurtherAliases = AliasSum::kExplicitAliases - 1;
constexpr double kTailStart = AliasSum::kExplicitAliases + 0.5;
constexpr std::size_t kFewestNodes = 4;
constexpr std::size_t kSpareNodes = 2;  // whose coefficients show whether the nodes resolve the aliases

// At kFullAccuracy; fewer points serve a lower one.
constexpr double kFullAccuracy = 3e-13;
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
Rule gauss_rule(std::size_t nodes) {
  std::vector<double> y;
  std::vector<double> w;
  for (double t = -3.8; t <= 3.2; t += 0.01) {
    const double value = std::exp(t - std::exp(-t));
    y.push_back(value);
    w.push_back(0.01 * value * (1.0 + std::exp(-t)) / (2.0 * std::cosh(pi * value)));
  }
  const auto n = static_cast<Eigen::Index>(nodes);
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

/// Number of nodes on [-band, band] that aliases from alias `k` on need: the error falls as (c + sqrt(c^2 - 1))^-nodes,
/// c the distance of the nearest singularity, the origin, over `band`.
std::size_t nodes_for(double k, double band, double accuracy) {
  const double c = 2.0 * pi * k / band;
  const auto nodes = static_cast<std::size_t>(std::lround(-std::log(accuracy) / std::acosh(c)));
  return std::max(kFewestNodes, nodes);
}

/// The matrix that maps values at Chebyshev nodes to coefficients.
Eigen::MatrixXd chebyshev_transform(std::size_t nodes) {
  const auto size = static_cast<Eigen::Index>(nodes);
  return Eigen::MatrixXd::NullaryExpr(size, size, [nodes](Eigen::Index n, Eigen::Index m) {
    return (n == 0 ? 1.0 : 2.0) / static_cast<double>(nodes) *
           std::cos(static_cast<double>(n) * chebyshev_angle(static_cast<std::size_t>(m), nodes));
  });
}

double last_coefficients(const Eigen::VectorXcd& a) {
  return a.tail(static_cast<Eigen::Index>(kSpareNodes)).cwiseAbs().maxCoeff();
}

}  // namespace

/// Where the nodes lie, and the quadrature of the tail.
struct AliasSum::Contour {
  double sigma;
  double step_s;
  double band;
  std::vector<double> gauss_node;
  std::vector<double> gauss_weight;
  double quadrature_step;
};

AliasSum::AliasSum(double sigma, double step_s, double band, double accuracy)
    : first_(chebyshev_transform(nodes_for(1.0, band, accuracy) + kSpareNodes)),
      further_(chebyshev_transform(nodes_for(2.0, band, accuracy) + kSpareNodes)),
      tail_(chebyshev_transform(nodes_for(kTailStart, band, accuracy))) {
  const double share = std::log(accuracy) / std::log(kFullAccuracy);  // of the points of full accuracy
  const Rule gauss = gauss_rule(static_cast<std::size_t>(std::lround(share * static_cast<double>(kGaussNodes))));
  const Contour contour{sigma, step_s, band, gauss.node, gauss.weight, kQuadratureStep / share};
  right_ = make_side(contour, 1.0);
  left_ = make_side(contour, -1.0);
}

AliasSum::Side AliasSum::make_side(const Contour& contour, double direction) const {
  Side side;
  struct Point {
    Complex offset;
    Complex weight;
  };
  // A group's points serve each of its nodes.
  const auto add_group = [&](const Eigen::MatrixXd& transform, const std::vector<Point>& points) {
    const auto nodes = static_cast<std::size_t>(transform.cols());
    const std::size_t first = side.offsets.size();
    for (const Point& point : points) side.offsets.push_back(point.offset);
    for (std::size_t m = 0; m < nodes; ++m) {
      const Complex node(contour.sigma, contour.band * std::cos(chebyshev_angle(m, nodes)));
      for (std::size_t k = 0; k < points.size(); ++k) {
        const Complex p = node + points[k].offset;
        side.points.add(p.real() / contour.step_s, p.imag() / contour.step_s);
        side.nodes.push_back({first + k, points[k].weight / p});
      }
    }
  };
  const auto turns = [](double k) { return Complex(0.0, 2.0 * pi * k); };
  add_group(first_, {{turns(1.0), 1.0}});
  std::vector<Point> further;
  for (std::size_t k = 0; k < kFurtherAliases; ++k) further.push_back({turns(static_cast<double>(k + 2)), 1.0});
  add_group(further_, further);
  std::vector<Point> tail;
  const Complex i(0.0, 1.0);
  const Complex start = turns(kTailStart);
  for (double t = kQuadratureFirst; t <= kQuadratureLast; t += contour.quadrature_step) {
    const double r = std::abs(start) * std::exp(0.5 * pi * std::sinh(t));
    const double slope = r * 0.5 * pi * std::cosh(t) * contour.quadrature_step;
    tail.push_back({start + direction * r, direction * slope / (2.0 * pi * i)});
  }
  for (std::size_t j = 0; j < contour.gauss_node.size(); ++j) {
    const double y = contour.gauss_node[j];
    const Complex weight = i * contour.gauss_weight[j] * std::exp(-pi * y);
    tail.push_back({start + 2.0 * pi * y, weight});
    tail.push_back({start - 2.0 * pi * y, -weight});
  }
  add_group(tail_, tail);
  return side;
}

std::vector<AliasSum::Series> AliasSum::evaluate(const TransferColumns& columns, double x, int skip_first) const {
  const Side& side = x < 0.0 ? left_ : right_;
  const std::size_t count = side.nodes.size();
  std::vector<Complex> shift(side.offsets.size(), 1.0);
  for (std::size_t k = 0; x != 0.0 && k < shift.size(); ++k) shift[k] = std::exp(-x * side.offsets[k]);
  std::vector<Complex> factor(count);
  for (std::size_t i = 0; i < count; ++i) factor[i] = side.nodes[i].weight * shift[side.nodes[i].offset];
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
    // Coefficients of a group of aliases from `points` values a node.
    const auto coefficients = [&](const Eigen::MatrixXd& transform, std::size_t points) {
      Eigen::VectorXcd values(transform.cols());
      for (Complex& value : values) value = next(points);
      return Eigen::VectorXcd(transform * values);
    };
    const Eigen::VectorXcd nearest = coefficients(first_, 1);
    const Eigen::VectorXcd beyond = coefficients(further_, kFurtherAliases);
    const std::size_t rest = (count - at) / static_cast<std::size_t>(tail_.cols());
    const Eigen::VectorXcd beyond_those = coefficients(tail_, rest);

    Series series;
    series.unresolved_first = last_coefficients(nearest);
    series.unresolved_further = last_coefficients(beyond);
    Eigen::VectorXcd sum = Eigen::VectorXcd::Zero(nearest.size());
    sum.head(beyond_those.size()) += beyond_those;
    if (skip_first < 1) sum += nearest;
    if (skip_first < kExplicitAliases) sum.head(beyond.size()) += beyond;
    // The aliases -k are the mirror image, so the sum keeps the real part of even and the imaginary part of odd terms.
    for (Eigen::Index n = 0; n < sum.size(); ++n) {
      series.a.push_back(2.0 * (n % 2 == 0 ? sum[n].real() : sum[n].imag()));
    }
    all.push_back(std::move(series));
  }
  return all;
}

}  // namespace eha::ident
