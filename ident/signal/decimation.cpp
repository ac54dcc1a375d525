// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/decimation.hpp"

#include <algorithm>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <numbers>
#include <numeric>

namespace eha::ident {
namespace {

using std::numbers::pi;

// Half length in new samples, and Kaiser's beta: -120 dB with a transition of one new sampling rate over two.
constexpr std::size_t kHalfLength = 8;
constexpr double kKaiserBeta = 12.265;

}  // namespace

std::vector<double> antialias_taps(std::size_t factor) {
  if (factor <= 1) return {};
  const auto half = static_cast<std::ptrdiff_t>(kHalfLength * factor);
  std::vector<double> taps;
  double sum = 0.0;
  for (std::ptrdiff_t m = -half; m <= half; ++m) {
    const double x = static_cast<double>(m) / static_cast<double>(factor);
    const double r = static_cast<double>(m) / static_cast<double>(half);
    const double sinc = m == 0 ? 1.0 : std::sin(pi * x) / (pi * x);
    taps.push_back(sinc * boost::math::cyl_bessel_i(0, kKaiserBeta * std::sqrt(1.0 - r * r)));
    sum += taps.back();
  }
  for (double& tap : taps) tap /= sum;
  return taps;
}

Comparison compare_every(std::size_t samples, std::size_t every, std::size_t discard) {
  Comparison comparison;
  comparison.every = every;
  comparison.taps = antialias_taps(every);
  const std::size_t half = comparison.taps.size() / 2;
  comparison.first = keep_every(every, std::max(discard, half)).first;
  if (comparison.first + half < samples) comparison.count = (samples - 1 - half - comparison.first) / every + 1;
  return comparison;
}

std::vector<double> filtered_noise_correlation(const Comparison& comparison) {
  std::vector<double> correlation;
  const std::vector<double>& taps = comparison.taps;
  for (std::size_t shift = 0; shift < taps.size(); shift += comparison.every) {
    correlation.push_back(
        std::inner_product(taps.begin() + static_cast<std::ptrdiff_t>(shift), taps.end(), taps.begin(), 0.0));
  }
  return correlation;
}

Eigen::VectorXd picked(const Eigen::Ref<const Eigen::VectorXd>& signal, const Comparison& comparison) {
  Eigen::VectorXd out(static_cast<Eigen::Index>(comparison.count));
  const auto length = static_cast<Eigen::Index>(comparison.taps.size());
  const Eigen::Map<const Eigen::VectorXd> taps(comparison.taps.data(), length);
  for (Eigen::Index j = 0; j < out.size(); ++j) {
    const auto n = static_cast<Eigen::Index>(comparison.first + static_cast<std::size_t>(j) * comparison.every);
    out[j] = length == 0 ? signal[n] : taps.dot(signal.segment(n - length / 2, length));
  }
  return out;
}

}  // namespace eha::ident
