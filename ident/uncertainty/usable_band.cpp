// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/uncertainty/usable_band.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <span>
#include <vector>

#include "ident/signal/fft.hpp"
#include "ident/structure/structure.hpp"

namespace eha::ident {
namespace {

constexpr double kCarries = 0.1;    // of the greatest amplitude
constexpr double kHalfLobe = 1.65;  // of a Hann window's main lobe where it falls to kCarries [1/T]
constexpr std::size_t kPadding = 4;
constexpr Eigen::Index kMostPaddedRows = 1'000'000;  // a longer record's bins are narrow enough without
constexpr Eigen::Index kFewestRows = 8;
constexpr Eigen::Index kRowsOfProducts = 1024;
constexpr std::size_t kBandPoints = 200;
constexpr double kOfNyquist = 0.8;  // above it a held input and the filter leave too little response to measure
constexpr double kFarAway = 100.0;  // factor beyond the band within which a resonance is searched

/// That of finite numbers: std::complex's own looks for infinities.
std::complex<double> product(const std::complex<double>& a, const std::complex<double>& b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

std::vector<double> logarithmic(double lowest_Hz, double highest_Hz) {
  if (!(highest_Hz > lowest_Hz)) return {lowest_Hz};
  std::vector<double> grid;
  for (std::size_t i = 0; i < kBandPoints; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(kBandPoints - 1);
    grid.push_back(lowest_Hz * std::pow(highest_Hz / lowest_Hz, share));
  }
  grid.back() = highest_Hz;
  return grid;
}

/// Returns the widest part of a grid, on a logarithmic scale, at whose points a predicate holds; none where that is a
/// single frequency of several.
template <typename Holds>
std::optional<FrequencyInterval> widest_part(const std::vector<double>& grid, const Holds& holds) {
  std::optional<FrequencyInterval> widest;
  std::optional<FrequencyInterval> part;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    if (!holds(i)) {
      part.reset();
      continue;
    }
    if (!part) part = {grid[i], grid[i]};
    part->highest_Hz = grid[i];
    const auto ratio = [](const FrequencyInterval& b) { return b.highest_Hz / b.lowest_Hz; };
    if (!widest || ratio(*part) > ratio(*widest)) widest = part;
  }
  if (widest && grid.size() > 1 && !(widest->highest_Hz > widest->lowest_Hz)) return std::nullopt;
  return widest;
}

bool moves_g(ParameterRole role) { return is_coefficient(role) || is_order(role) || role == ParameterRole::delay; }

bool is_undetermined(const Model& model) {
  return std::any_of(model.parameters.begin(), model.parameters.end(),
                     [](const ParameterEstimate& p) { return !p.fixed && moves_g(p.role) && !std::isfinite(p.std); });
}

}  // namespace

std::optional<FrequencyInterval> excited_band(const Eigen::Ref<const Eigen::VectorXd>& input, double step_s) {
  const Eigen::Index rows = input.size();
  if (rows < kFewestRows) return {};
  const std::size_t padding = rows > kMostPaddedRows ? 1 : kPadding;
  const RealFft fft(fast_length(padding * static_cast<std::size_t>(rows)));
  std::vector<double> signal(fft.length(), 0.0);
  const double mean = input.mean();
  const double turn = 2.0 * std::numbers::pi / static_cast<double>(rows);
  const std::complex<double> step = std::polar(1.0, turn);
  std::complex<double> at;
  for (Eigen::Index k = 0; k < rows; ++k) {
    // A cosine a row would take longer than the transform; by products its error grows by 1e-16 a row.
    at = k % kRowsOfProducts == 0 ? std::polar(1.0, turn * static_cast<double>(k)) : product(at, step);
    signal[static_cast<std::size_t>(k)] = (input[k] - mean) * 0.5 * (1.0 - at.real());
  }
  std::vector<std::complex<double>> spectrum(fft.bins());
  fft.forward(signal, spectrum);
  double greatest_power = 0.0;
  for (const auto& bin : spectrum) greatest_power = std::max(greatest_power, std::norm(bin));
  const double greatest = std::sqrt(greatest_power);
  if (!(greatest > 1e-12 * static_cast<double>(rows) * input.cwiseAbs().maxCoeff())) return {};
  const auto carries = [&](const std::complex<double>& bin) {
    return std::norm(bin) >= kCarries * kCarries * greatest_power;
  };
  const auto first = std::find_if(spectrum.begin(), spectrum.end(), carries) - spectrum.begin();
  const auto behind = std::find_if(spectrum.rbegin(), spectrum.rend(), carries).base() - spectrum.begin();
  const double bin_Hz = 1.0 / (static_cast<double>(fft.length()) * step_s);
  const double period_Hz = 1.0 / (static_cast<double>(rows) * step_s);
  const double lobe_Hz = kHalfLobe * period_Hz;
  FrequencyInterval band{static_cast<double>(first) * bin_Hz + lobe_Hz,
                         static_cast<double>(behind - 1) * bin_Hz - lobe_Hz};
  // A line whose lobe reaches down to 0 does not show its own middle.
  if (first == 0) band.lowest_Hz = period_Hz;
  band.highest_Hz = std::max(band.highest_Hz, band.lowest_Hz);
  return band;
}

std::optional<FrequencyInterval> usable_band(const Model& model, const ParameterCovariance& known,
                                             const FrequencyInterval& excited, const AcceptanceLimits& limits) {
  if (known.parameters.empty() || is_undetermined(model)) return {};
  double highest_Hz = excited.highest_Hz;
  if (model.estimation && model.estimation->compared_step_s) {
    highest_Hz = std::min(highest_Hz, kOfNyquist * 0.5 / *model.estimation->compared_step_s);
  }
  if (!(highest_Hz >= excited.lowest_Hz)) return {};
  const std::vector<double> grid = logarithmic(excited.lowest_Hz, highest_Hz);
  const BodeCurve curve = bode_curve(model, grid, known);
  return widest_part(grid, [&](std::size_t i) {
    return curve.gain_std_dB[i] <= limits.usable_gain_error_dB &&
           curve.phase_std_deg[i] <= limits.usable_phase_error_deg;
  });
}

std::optional<FrequencyInterval> agreeing_band(const Model& model, const Model& better, const FrequencyInterval& band,
                                               const AcceptanceLimits& limits) {
  const std::vector<double> grid = logarithmic(band.lowest_Hz, band.highest_Hz);
  const BodeCurve a = bode_curve(model, grid, {});
  const BodeCurve b = bode_curve(better, grid, {});
  return widest_part(grid, [&](std::size_t i) {
    return std::abs(a.gain_dB[i] - b.gain_dB[i]) <= limits.usable_gain_error_dB &&
           std::abs(std::remainder(a.phase_deg[i] - b.phase_deg[i], 360.0)) <= limits.usable_phase_error_deg;
  });
}

std::optional<double> resonance_Hz(const Model& model, const FrequencyInterval& band) {
  const std::vector<double> grid = logarithmic(band.lowest_Hz / kFarAway, band.highest_Hz * kFarAway);
  const BodeCurve curve = bode_curve(model, grid, {});
  std::optional<std::size_t> highest;
  for (std::size_t i = 1; i + 1 < grid.size(); ++i) {
    const bool is_peak = curve.gain_dB[i] > curve.gain_dB[i - 1] && curve.gain_dB[i] > curve.gain_dB[i + 1];
    if (is_peak && (!highest || curve.gain_dB[i] > curve.gain_dB[*highest])) highest = i;
  }
  if (!highest) return {};
  return grid[*highest];
}

}  // namespace eha::ident
