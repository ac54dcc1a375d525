// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/control/sampled_plant.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

constexpr int kAliases = 6;
constexpr int kPoints = 40;

double coefficient(const std::vector<Term>& terms, int order) {
  double sum = 0.0;
  for (const Term& t : terms) sum += std::lround(t.order) == order ? t.coefficient : 0.0;
  return sum;
}

}  // namespace

Complex sampled_plant(const TransferFunction& g, double tick_s, double late_s, double w_rad_s) {
  const Complex held = 1.0 - std::polar(1.0, -w_rad_s * tick_s);
  Complex sum = 0.0;
  for (int k = -kAliases; k <= kAliases; ++k) {
    const double w = w_rad_s + 2.0 * std::numbers::pi * k / tick_s;
    // Real coefficients: G at a negative frequency is the conjugate.
    const Complex value = frequency_response(g, Complex(0.0, std::abs(w)));
    sum += (w < 0.0 ? std::conj(value) : value) * std::polar(1.0, -w * late_s) / Complex(0.0, w * tick_s);
  }
  return held * sum;
}

std::optional<InverseExpansion> inverse_expansion(const TransferFunction& g, const FrequencyInterval& band) {
  InverseExpansion result;
  if (has_whole_orders(g.numerator) && has_whole_orders(g.denominator)) {
    std::array<double, 3> n{};
    std::array<double, 3> d{};
    for (int i = 0; i < 3; ++i) {
      n.at(static_cast<std::size_t>(i)) = coefficient(g.numerator, i);
      d.at(static_cast<std::size_t>(i)) = coefficient(g.denominator, i);
    }
    if (n[0] == 0.0) return std::nullopt;
    const double q0 = d[0] / n[0];
    const double q1 = (d[1] - q0 * n[1]) / n[0];
    const double q2 = (d[2] - q1 * n[1] - q0 * n[2]) / n[0];
    const double t = g.delay_s;
    result = {q0, q1 + t * q0, q2 + t * q1 + 0.5 * t * t * q0, 0.0};
  } else {
    // (c0 + c1 s + c2 s^2) G(s) = 1 at frequencies of equal ratio.
    Eigen::MatrixXd a(2 * kPoints, 3);
    Eigen::VectorXd b(2 * kPoints);
    const std::vector<double> grid =
        log_grid(2.0 * std::numbers::pi * band.lowest_Hz, 2.0 * std::numbers::pi * band.highest_Hz, kPoints);
    const double scale = grid.back();
    for (int i = 0; i < kPoints; ++i) {
      const Complex s(0.0, grid[static_cast<std::size_t>(i)]);
      const Complex value = frequency_response(g, s);
      const std::array<Complex, 3> column{value, value * s / scale, value * s * s / (scale * scale)};
      for (int j = 0; j < 3; ++j) {
        a(2 * i, j) = column.at(static_cast<std::size_t>(j)).real();
        a(2 * i + 1, j) = column.at(static_cast<std::size_t>(j)).imag();
      }
      b(2 * i) = 1.0;
      b(2 * i + 1) = 0.0;
    }
    const Eigen::VectorXd c = a.colPivHouseholderQr().solve(b);
    const Eigen::VectorXd off = a * c - b;
    for (int i = 0; i < kPoints; ++i) {
      result.error_percent = std::max(result.error_percent, 100.0 * std::hypot(off(2 * i), off(2 * i + 1)));
    }
    result.position = c(0);
    result.velocity = c(1) / scale;
    result.acceleration = c(2) / (scale * scale);
  }
  if (!(result.velocity > 0.0) || !std::isfinite(result.position) || !std::isfinite(result.acceleration)) {
    return std::nullopt;
  }
  return result;
}

}  // namespace eha::ident
