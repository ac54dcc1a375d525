// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/fast_resonance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "ident/fractional/poles.hpp"
#include "ident/model/engineering_form.hpp"

namespace eha::ident {
namespace {

constexpr double kLightlyDamped = 0.3;

/// The poles of whole orders other than 0.
std::vector<std::complex<double>> poles_of(const Model& model) {
  const TransferFunction& g = model.transfer_function;
  if (model.grey_box || !has_whole_orders(g.denominator)) return {};
  const ReducedPolynomial polynomial = reduced(g.denominator);
  return polynomial.terms.size() < 2 ? std::vector<std::complex<double>>() : commensurate_roots(polynomial, 1.0);
}

double damping_of(std::complex<double> pole) { return -pole.real() / std::abs(pole); }

}  // namespace

std::optional<double> fastest_resonance_Hz(const Model& model) {
  double fastest_rad_s = 0.0;
  for (const std::complex<double>& pole : poles_of(model)) {
    if (damping_of(pole) < kLightlyDamped) fastest_rad_s = std::max(fastest_rad_s, std::abs(pole.imag()));
  }
  if (!(fastest_rad_s > 0.0)) return {};
  return fastest_rad_s / (2.0 * std::numbers::pi);
}

double least_damping(const Model& model) {
  double least = 1.0;
  for (const std::complex<double>& pole : poles_of(model)) {
    if (pole.imag() != 0.0) least = std::min(least, damping_of(pole));
  }
  return least;
}

std::string fast_resonance_sentence(double resonance_Hz, double row_s) {
  const double other_Hz = 1.0 / row_s - resonance_Hz;
  return fmt::format(
      "The resonance at {:.3g} Hz is more than half the {:.3g} Hz that rows every {:.3g} s can show: one at {:.3g} Hz "
      "looks the same in them, unless a filter before the sampling kept it out; record with rows every {:.2g} s or "
      "less.",
      resonance_Hz, 0.5 / row_s, row_s, other_Hz, 0.25 / other_Hz);
}

}  // namespace eha::ident
