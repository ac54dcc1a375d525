// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/fractional/grunwald_letnikov.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "ident/fractional/transfer_columns.hpp"
#include "ident/signal/fft.hpp"

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

// The wrap-around is damped by rho^L; rounding errors are amplified by rho^-N = 10^5.5 at L = 2N.
constexpr double kWrapAround = 1e-11;

/// Returns the delayed input, linear between samples.
Eigen::VectorXd delayed(const Eigen::Ref<const Eigen::VectorXd>& input, double delay) {
  const double whole = std::floor(delay);
  const double fraction = delay - whole;
  Eigen::VectorXd out = Eigen::VectorXd::Zero(input.size());
  if (whole >= static_cast<double>(input.size())) return out;
  const auto shift = static_cast<Eigen::Index>(whole);
  for (Eigen::Index n = shift; n < input.size(); ++n) {
    out[n] = (1.0 - fraction) * input[n - shift];
    if (n > shift) out[n] += fraction * input[n - shift - 1];
  }
  return out;
}

/// A kernel reversed, so that its sums are dot products of contiguous pieces, without the zeros that it ends with: of
/// integer orders it has as many weights as the highest one and one more.
class FiniteKernel {
 public:
  FiniteKernel(const std::vector<Term>& terms, double step_s, Eigen::Index samples) {
    const Eigen::VectorXd kernel = gl_kernel(terms, step_s, samples);
    length_ = samples;
    while (length_ > 1 && kernel[length_ - 1] == 0.0) --length_;
    reversed_ = kernel.head(length_).reverse();
  }

  [[nodiscard]] double first() const { return reversed_[length_ - 1]; }

  /// sum_{k>=1} A_k y_{n-k}
  [[nodiscard]] double of_past(const Eigen::VectorXd& y, Eigen::Index n) const {
    const Eigen::Index reach = std::min(n, length_ - 1);
    return reversed_.segment(length_ - 1 - reach, reach).dot(y.segment(n - reach, reach));
  }

  /// sum_k A_k u_{n-k} at every n.
  [[nodiscard]] Eigen::VectorXd over(const Eigen::VectorXd& u) const {
    if (length_ == 1) return first() * u;
    Eigen::VectorXd sums(u.size());
    for (Eigen::Index n = 0; n < u.size(); ++n) sums[n] = first() * u[n] + of_past(u, n);
    return sums;
  }

 private:
  Eigen::Index length_ = 0;
  Eigen::VectorXd reversed_;
};

}  // namespace

Eigen::VectorXd gl_kernel(const std::vector<Term>& terms, double step_s, Eigen::Index samples) {
  Eigen::VectorXd kernel = Eigen::VectorXd::Zero(samples);
  for (const Term& term : terms) {
    double weight = term.coefficient * std::pow(step_s, -term.order);
    for (Eigen::Index k = 0; k < samples && weight != 0.0; ++k) {
      if (k > 0) weight *= 1.0 - (term.order + 1.0) / static_cast<double>(k);
      kernel[k] += weight;
    }
  }
  return kernel;
}

Eigen::VectorXd simulate_gl_directly(const TransferFunction& g, const Eigen::Ref<const Eigen::VectorXd>& input,
                                     double step_s) {
  const Eigen::Index n_samples = input.size();
  const Eigen::VectorXd u = delayed(input, g.delay_s / step_s);
  const Eigen::VectorXd forced = FiniteKernel(g.numerator, step_s, n_samples).over(u);
  const FiniteKernel a(g.denominator, step_s, n_samples);
  Eigen::VectorXd y(n_samples);
  for (Eigen::Index n = 0; n < n_samples; ++n) y[n] = (forced[n] - a.of_past(y, n)) / a.first();
  return y;
}

Eigen::VectorXd simulate_by_quadrature(const TransferFunction& g, const Eigen::Ref<const Eigen::VectorXd>& input,
                                       double step_s, Quadrature quadrature) {
  const auto samples = static_cast<std::size_t>(input.size());
  const std::size_t length = fast_length(2 * samples + 16);
  const double sigma = -std::log(kWrapAround) / static_cast<double>(length);
  const Eigen::VectorXd u = delayed(input, g.delay_s / step_s);
  std::vector<double> signal(length, 0.0);
  for (std::size_t n = 0; n < samples; ++n) {
    signal[n] = u[static_cast<Eigen::Index>(n)] * std::exp(-sigma * static_cast<double>(n));
  }
  const RealFft fft(length);
  std::vector<Complex> spectrum(fft.bins());
  fft.forward(signal, spectrum);

  LaplacePoints points;
  std::vector<Complex> hold(fft.bins());
  for (std::size_t j = 0; j < fft.bins(); ++j) {
    const double theta = 2.0 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(length);
    const Complex z = std::polar(std::exp(-sigma), -theta);
    const Complex delta = quadrature == Quadrature::bdf1 ? 1.0 - z : 1.5 - 2.0 * z + 0.5 * z * z;
    points.add(delta.real() / step_s, delta.imag() / step_s);
    hold[j] = (1.0 - z) / delta;
  }
  const TransferColumns columns(g, {g.numerator}, {});
  std::vector<double> re(fft.bins());
  std::vector<double> im(fft.bins());
  columns.evaluate(points, 0, fft.bins(), re.data(), im.data(), fft.bins());
  for (std::size_t j = 0; j < fft.bins(); ++j) spectrum[j] *= hold[j] * Complex(re[j], im[j]);
  fft.inverse(spectrum, signal);

  Eigen::VectorXd y(input.size());
  for (std::size_t n = 0; n < samples; ++n) {
    y[static_cast<Eigen::Index>(n)] =
        signal[n] * std::exp(sigma * static_cast<double>(n)) / static_cast<double>(length);
  }
  return y;
}

}  // namespace eha::ident
