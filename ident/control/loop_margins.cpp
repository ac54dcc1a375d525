// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/control/loop_margins.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

constexpr double kPi = std::numbers::pi;

/// Whether arg(1 + L) turns as that of a stable closed loop. A pair of unstable poles adds 2 pi, so half of that
/// distinguishes the two, regardless of the grid's ends.
bool is_stable(std::span<const Complex> open_loop, double order_at_zero) {
  double turn = 0.0;
  for (std::size_t i = 1; i < open_loop.size(); ++i) {
    turn += std::arg((1.0 + open_loop[i]) / (1.0 + open_loop[i - 1]));
  }
  return std::abs(turn - 0.5 * kPi * order_at_zero) < kPi;
}

/// Returns the height of a parabola's top through three points of equal distance, the middle one the greatest.
double refined(double left, double middle, double right) {
  const double curvature = left - 2.0 * middle + right;
  if (!(curvature < 0.0)) return middle;
  const double slope = 0.5 * (right - left);
  return middle - 0.5 * slope * slope / curvature;
}

struct Peak {
  double value = 0.0;
  std::size_t at = 0;
};

template <typename Function>
Peak peak(std::size_t count, const Function& value) {
  Peak top{value(0), 0};
  for (std::size_t i = 1; i < count; ++i) {
    if (const double v = value(i); v > top.value) top = {v, i};
  }
  if (top.at > 0 && top.at + 1 < count) top.value = refined(value(top.at - 1), top.value, value(top.at + 1));
  return top;
}

Peak sensitivity(std::span<const Complex> open_loop) {
  return peak(open_loop.size(), [&](std::size_t i) { return 1.0 / std::abs(1.0 + open_loop[i]); });
}

Peak complementary(std::span<const Complex> open_loop) {
  return peak(open_loop.size(), [&](std::size_t i) { return std::abs(open_loop[i]) / std::abs(1.0 + open_loop[i]); });
}

}  // namespace

std::vector<double> log_grid(double low_rad_s, double high_rad_s, int points) {
  std::vector<double> grid;
  grid.reserve(static_cast<std::size_t>(points));
  for (int i = 0; i < points; ++i) {
    grid.push_back(low_rad_s * std::pow(high_rad_s / low_rad_s, static_cast<double>(i) / (points - 1)));
  }
  return grid;
}

double sensitivity_peak(std::span<const double> w_rad_s, std::span<const Complex> open_loop, double order_at_zero) {
  if (w_rad_s.empty() || !is_stable(open_loop, order_at_zero)) return std::numeric_limits<double>::infinity();
  return std::max(sensitivity(open_loop).value, complementary(open_loop).value);
}

LoopMargins loop_margins(std::span<const double> w_rad_s, std::span<const Complex> open_loop, double order_at_zero) {
  LoopMargins margins;
  if (w_rad_s.empty() || !is_stable(open_loop, order_at_zero)) return margins;
  margins.is_stable = true;
  const Peak s = sensitivity(open_loop);
  margins.ms = s.value;
  margins.ms_rad_s = w_rad_s[s.at];
  margins.mt = complementary(open_loop).value;
  for (std::size_t i = 1; i < open_loop.size(); ++i) {
    const Complex a = open_loop[i - 1];
    const Complex b = open_loop[i];
    const double log_a = std::log(std::abs(a));
    const double log_b = std::log(std::abs(b));
    const double turn = std::arg(b / a);
    if ((log_a >= 0.0) != (log_b >= 0.0)) {
      const double part = log_a / (log_a - log_b);
      const double w = w_rad_s[i - 1] * std::pow(w_rad_s[i] / w_rad_s[i - 1], part);
      // From -pi clockwise to the phase at the crossing: 0 .. 2 pi.
      double lead = std::fmod(std::arg(a) + part * turn + kPi, 2.0 * kPi);
      if (lead < 0.0) lead += 2.0 * kPi;
      margins.phase_deg = std::min(margins.phase_deg, std::min(lead, 2.0 * kPi - lead) * 180.0 / kPi);
      margins.delay_s = std::min(margins.delay_s, lead / w);
      margins.crossover_rad_s = std::max(margins.crossover_rad_s, w);
    }
    // The negative real axis between the two.
    if (std::real(a) < 0.0 && std::real(b) < 0.0 && (std::imag(a) >= 0.0) != (std::imag(b) >= 0.0)) {
      const double part = std::imag(a) / (std::imag(a) - std::imag(b));
      const double size = std::exp(log_a + part * (log_b - log_a));
      if (size < 1.0) margins.gain = std::min(margins.gain, 1.0 / size);
    }
  }
  return margins;
}

}  // namespace eha::ident
