// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/export/vector_fitting.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <optional>

#include "core/error.hpp"
#include "ident/export/pole_groups.hpp"
#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/linear_algebra/spectra.hpp"

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

constexpr int kPointsPerDecade = 24;
constexpr double kLargestChange = 0.25;  // of ln G between two frequencies
constexpr double kClosest = 1.0005;      // ratio of two frequencies that are not split further
constexpr std::size_t kMostPoints = 800;
constexpr int kIterations = 12;
constexpr int kFewestPoles = 4;
constexpr int kMostPoles = 30;
constexpr double kStaticWeight = 5.0;  // of the gain at s = 0 among the frequencies
constexpr double kOrderTolerance = 1e-9;
constexpr double kNoLoss = 1e-9;  // least damping of a pole, as a share of its size

double highest(const std::vector<Term>& terms) {
  double order = 0.0;
  for (const Term& term : terms) {
    if (term.coefficient != 0.0) order = std::max(order, term.order);
  }
  return order;
}

double lowest(const std::vector<Term>& terms) {
  double order = kOrderLimit;
  for (const Term& term : terms) {
    if (term.coefficient != 0.0) order = std::min(order, term.order);
  }
  return order;
}

double coefficient_at(const std::vector<Term>& terms, double order) {
  double sum = 0.0;
  for (const Term& term : terms) sum += std::abs(term.order - order) <= kOrderTolerance ? term.coefficient : 0.0;
  return sum;
}

/// Values of G at some points, weighted by 1/|G|; the last point may be s = 0.
struct Samples {
  std::vector<Complex> s;
  std::vector<Complex> g;
  std::vector<double> weight;
  bool has_direct = false;
};

/// Values of the real basis functions of the poles at s: 1/(s - p) of a real pole, the sum and the difference times i
/// of a pair's two fractions, whose second pole follows the first.
std::vector<Complex> basis(const std::vector<Complex>& poles, Complex s) {
  std::vector<Complex> values;
  for (std::size_t i = 0; i < poles.size(); ++i) {
    const Complex fraction = 1.0 / (s - poles[i]);
    if (poles[i].imag() == 0.0) {
      values.push_back(fraction);
      continue;
    }
    const Complex mirrored = 1.0 / (s - poles[++i]);
    values.push_back(fraction + mirrored);
    values.push_back(Complex(0.0, 1.0) * (fraction - mirrored));
  }
  return values;
}

Eigen::VectorXd solve_scaled(Eigen::MatrixXd a, const Eigen::VectorXd& b) {
  const Eigen::VectorXd scale = a.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  a = (a * scale.asDiagonal()).eval();
  return scale.cwiseProduct(Eigen::VectorXd(solve_pivoted(a, b)));
}

/// Coefficients of the basis functions (and of 1 with a direct part) nearest to the samples. With sigma also those of
/// -G times the basis functions, after the others.
Eigen::VectorXd fitted(const Samples& samples, const std::vector<Complex>& poles, bool with_sigma) {
  const auto n = static_cast<Eigen::Index>(poles.size());
  const Eigen::Index own = n + (samples.has_direct ? 1 : 0);
  const auto rows = static_cast<Eigen::Index>(samples.s.size());
  Eigen::MatrixXd a(2 * rows, own + (with_sigma ? n : 0));
  Eigen::VectorXd b(2 * rows);
  const auto put = [&](Eigen::Index row, Eigen::Index column, Complex value) {
    a(2 * row, column) = value.real();
    a(2 * row + 1, column) = value.imag();
  };
  for (Eigen::Index row = 0; row < rows; ++row) {
    const auto i = static_cast<std::size_t>(row);
    const std::vector<Complex> values = basis(poles, samples.s[i]);
    const double weight = samples.weight[i];
    for (Eigen::Index k = 0; k < n; ++k) {
      put(row, k, weight * values[static_cast<std::size_t>(k)]);
      if (with_sigma) put(row, own + k, -weight * samples.g[i] * values[static_cast<std::size_t>(k)]);
    }
    if (samples.has_direct) put(row, n, weight);
    b[2 * row] = weight * samples.g[i].real();
    b[2 * row + 1] = weight * samples.g[i].imag();
  }
  return solve_scaled(std::move(a), b);
}

/// Zeros of 1 + sum_k c_k basis_k: eigenvalues of A - b c', reflected into the left half plane, pairs together.
std::vector<Complex> relocated(const std::vector<Complex>& poles, const Eigen::VectorXd& c, double least_size) {
  const auto n = static_cast<Eigen::Index>(poles.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Ones(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Complex pole = poles[static_cast<std::size_t>(k)];
    a(k, k) = pole.real();
    if (pole.imag() == 0.0) continue;
    a(k, k + 1) = pole.imag();
    a(k + 1, k) = -pole.imag();
    a(k + 1, k + 1) = pole.real();
    b[k] = 2.0;
    b[k + 1] = 0.0;
    ++k;
  }
  const Eigen::VectorXcd zeros = eigenvalues(a - b * c.transpose());
  std::vector<Complex> next;
  for (const Complex& zero : zeros) {
    if (zero.imag() < 0.0) continue;
    const double size = std::max(std::abs(zero), least_size);
    const double real = -std::max(std::abs(zero.real()), kNoLoss * size);
    if (zero.imag() == 0.0) {
      next.emplace_back(std::min(real, -least_size));
    } else {
      next.emplace_back(real, zero.imag());
      next.emplace_back(real, -zero.imag());
    }
  }
  return next;
}

struct Rational {
  std::vector<Complex> poles;     ///< pairs together
  std::vector<Complex> residues;  ///< one a pole
  double direct = 0.0;
};

Rational with_residues(const Samples& samples, std::vector<Complex> poles) {
  const Eigen::VectorXd c = fitted(samples, poles, false);
  Rational r{std::move(poles), {}, samples.has_direct ? c[c.size() - 1] : 0.0};
  for (std::size_t i = 0; i < r.poles.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (r.poles[i].imag() == 0.0) {
      r.residues.emplace_back(c[k]);
      continue;
    }
    r.residues.emplace_back(c[k], c[k + 1]);
    r.residues.emplace_back(c[k], -c[k + 1]);
    ++i;
  }
  return r;
}

double error_of(const Samples& samples, const Rational& r) {
  double greatest = 0.0;
  for (std::size_t i = 0; i < samples.s.size(); ++i) {
    Complex value = r.direct;
    for (std::size_t k = 0; k < r.poles.size(); ++k) value += r.residues[k] / (samples.s[i] - r.poles[k]);
    greatest = std::max(greatest, std::abs(value - samples.g[i]) / std::abs(samples.g[i]));
  }
  return greatest;
}

/// Returns the best of the iterations from real poles spread over the band.
std::pair<Rational, double> fit_with(const Samples& samples, const AngularBand& band, int count) {
  std::vector<Complex> poles;
  for (int i = 0; i < count; ++i) {
    const double share = (i + 0.5) / count;
    poles.emplace_back(-band.from_rad_s * std::pow(band.to_rad_s / band.from_rad_s, share));
  }
  std::pair<Rational, double> best{{}, 1e300};
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Eigen::VectorXd all = fitted(samples, poles, true);
    if (!all.allFinite()) break;
    poles = relocated(poles, all.tail(static_cast<Eigen::Index>(poles.size())), 1e-3 * band.from_rad_s);
    Rational now = with_residues(samples, poles);
    const double error = error_of(samples, now);
    if (error < best.second) best = {std::move(now), error};
  }
  return best;
}

/// r(s)/s: a pole at 0 takes r(0).
Rational integrated(Rational r) {
  Complex at_zero = r.direct;
  for (std::size_t k = 0; k < r.poles.size(); ++k) {
    at_zero -= r.residues[k] / r.poles[k];
    r.residues[k] /= r.poles[k];
  }
  r.direct = 0.0;
  r.poles.emplace_back(0.0);
  r.residues.emplace_back(at_zero.real());
  return r;
}

Sections sections_of(const Rational& r, double delay_s) {
  Sections sections{{}, r.direct, delay_s};
  for (const std::vector<Complex>& group : grouped(r.poles)) {
    Polynomial numerator(group.size(), 0.0);
    for (std::size_t k = 0; k < group.size(); ++k) {
      std::vector<Complex> others = group;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
      std::vector<Complex> rest{1.0};
      for (const Complex& zero : others) {
        rest.push_back(0.0);
        for (std::size_t i = rest.size() - 1; i > 0; --i) rest[i] -= zero * rest[i - 1];
      }
      const auto at = std::find(r.poles.begin(), r.poles.end(), group[k]);
      const Complex residue = r.residues[static_cast<std::size_t>(at - r.poles.begin())];
      for (std::size_t i = 0; i < rest.size(); ++i) numerator[i] += (residue * rest[i]).real();
    }
    sections.list.push_back(section_of(numerator, from_zeros(group)));
  }
  return sections;
}

}  // namespace

std::vector<double> dense_grid(const TransferFunction& g, const AngularBand& band) {
  TransferFunction undelayed = g;
  undelayed.delay_s = 0.0;
  const auto log_g = [&](double w) { return std::log(frequency_response(undelayed, Complex(0.0, w))); };
  const double decades = std::log10(band.to_rad_s / band.from_rad_s);
  const int points = std::max(3, static_cast<int>(std::ceil(decades * kPointsPerDecade)) + 1);
  std::vector<double> grid{band.from_rad_s};
  Complex before = log_g(band.from_rad_s);
  for (int i = 1; i < points; ++i) {
    const double to =
        band.from_rad_s * std::pow(band.to_rad_s / band.from_rad_s, static_cast<double>(i) / (points - 1));
    // Splits the interval where G turns quickly.
    std::vector<double> stack{to};
    while (!stack.empty()) {
      const double w = stack.back();
      const Complex now = log_g(w);
      const double change = std::abs(
          Complex(now.real() - before.real(), std::remainder(now.imag() - before.imag(), 2.0 * std::numbers::pi)));
      if (change > kLargestChange && w / grid.back() > kClosest && grid.size() + stack.size() < kMostPoints) {
        stack.push_back(std::sqrt(w * grid.back()));
        continue;
      }
      grid.push_back(w);
      before = now;
      stack.pop_back();
    }
  }
  return grid;
}

FrequencyDeviation deviation(const Sections& sections, const TransferFunction& g,
                             const std::vector<double>& frequencies_rad_s) {
  TransferFunction undelayed = g;
  undelayed.delay_s = 0.0;
  FrequencyDeviation greatest;
  for (const double w : frequencies_rad_s) {
    const Complex s(0.0, w);
    const Complex ratio = frequency_response(sections, s) / frequency_response(undelayed, s);
    greatest.gain_percent = std::max(greatest.gain_percent, 100.0 * std::abs(std::abs(ratio) - 1.0));
    greatest.phase_deg = std::max(greatest.phase_deg, std::abs(std::arg(ratio)) * 180.0 / std::numbers::pi);
    greatest.relative = std::max(greatest.relative, std::abs(ratio - 1.0));
  }
  return greatest;
}

Sections approximate(const TransferFunction& g, const AngularBand& band, double wanted) {
  TransferFunction h = g;
  h.delay_s = 0.0;
  const double at_zero = lowest(g.denominator) - lowest(g.numerator);
  if (at_zero >= 2.0 - kOrderTolerance) {
    throw ConfigError("transfer_function: a pole of order 2 or more at s = 0 beside fractional orders is not exported");
  }
  const bool integrates = at_zero >= 1.0 - kOrderTolerance;
  if (integrates) {
    // H = s G
    const double shared = std::min(1.0, lowest(g.denominator));
    for (Term& term : h.denominator) term.order -= shared;
    for (Term& term : h.numerator) term.order += 1.0 - shared;
  }
  Samples samples;
  samples.has_direct = highest(h.numerator) >= highest(h.denominator) - kOrderTolerance;
  for (const double w : dense_grid(h, band)) {
    samples.s.emplace_back(0.0, w);
    samples.g.push_back(frequency_response(h, samples.s.back()));
    samples.weight.push_back(1.0 / std::abs(samples.g.back()));
  }
  const double low = lowest(h.denominator);
  if (std::abs(low - lowest(h.numerator)) <= kOrderTolerance) {
    samples.s.emplace_back(0.0);
    samples.g.emplace_back(coefficient_at(h.numerator, low) / coefficient_at(h.denominator, low));
    samples.weight.push_back(kStaticWeight / std::abs(samples.g.back()));
  }
  std::pair<Rational, double> best{{}, 1e300};
  for (int count = kFewestPoles; count <= kMostPoles && best.second > wanted; count += 2) {
    auto now = fit_with(samples, band, count);
    if (now.second < best.second) best = std::move(now);
  }
  return sections_of(integrates ? integrated(best.first) : best.first, g.delay_s);
}

}  // namespace eha::ident
