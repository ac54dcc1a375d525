// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/frequency_response.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <numbers>
#include <span>

#include "core/error.hpp"
#include "ident/signal/fft.hpp"

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

// A line farther than this from a harmonic, in cycles over one period, is refused; rounding errors are far smaller.
constexpr double kOffHarmonic = 1e-3;
constexpr double kCarriesInput = 0.1;
// An input below this share of the greatest line is rounding of the converter, not excitation.
constexpr double kLeastInput = 1e-6;
constexpr std::size_t kNeighbours = 2;
// Silent odd lines of an odd-random multisine, one in each four, are at most seven odd lines apart.
constexpr std::size_t kReach = 14;

/// Spectra of every period, one a column, and their mean; scaled so that a cosine of amplitude 1 gives 1.
struct Spectra {
  Eigen::MatrixXcd periods;
  Eigen::VectorXcd mean;
};

Spectra spectra_of(const Eigen::MatrixXd& periods) {
  const RealFft transform(static_cast<std::size_t>(periods.rows()));
  Spectra spectra;
  spectra.periods.resize(static_cast<Eigen::Index>(transform.bins()), periods.cols());
  for (Eigen::Index p = 0; p < periods.cols(); ++p) {
    transform.forward(std::span<const double>(periods.col(p).data(), transform.length()),
                      std::span<Complex>(spectra.periods.col(p).data(), transform.bins()));
  }
  spectra.periods *= 2.0 / static_cast<double>(periods.rows());
  spectra.mean = spectra.periods.rowwise().mean();
  return spectra;
}

/// The highest harmonic below the Nyquist frequency.
std::size_t highest(const Periods& periods) { return (periods.length - 1) / 2; }

double greatest_input(const Eigen::VectorXcd& input, const Periods& periods) {
  return input.segment(1, static_cast<Eigen::Index>(highest(periods))).cwiseAbs().maxCoeff();
}

std::vector<std::size_t> harmonics_that_carry(const Eigen::VectorXcd& input, const Periods& periods) {
  const double least = kCarriesInput * greatest_input(input, periods);
  std::vector<std::size_t> harmonics;
  for (std::size_t k = 1; k <= highest(periods); ++k) {
    const double amplitude = std::abs(input[static_cast<Eigen::Index>(k)]);
    if (amplitude > 0.0 && amplitude >= least) harmonics.push_back(k);
  }
  if (harmonics.empty()) throw DataError("frequency response: the input is constant; expected one that moves");
  return harmonics;
}

std::vector<std::size_t> harmonics_of(const std::vector<double>& lines_Hz, const Eigen::VectorXcd& input,
                                      const Periods& periods, double step_s) {
  const double period_s = static_cast<double>(periods.length) * step_s;
  const double least = kLeastInput * greatest_input(input, periods);
  std::vector<std::size_t> harmonics;
  for (const double f : lines_Hz) {
    const double cycles = f * period_s;
    if (std::abs(cycles - std::round(cycles)) > kOffHarmonic || !(cycles > 0.5) ||
        cycles > static_cast<double>(highest(periods)) + 0.5) {
      throw DataError(fmt::format(
          "frequency response: {} Hz is no harmonic of the period of {} s below the Nyquist frequency", f, period_s));
    }
    const auto k = static_cast<std::size_t>(std::llround(cycles));
    if (!(std::abs(input[static_cast<Eigen::Index>(k)]) > least)) {
      throw DataError(
          fmt::format("frequency response: the input holds nothing at {} Hz, where it should be excited", f));
    }
    harmonics.push_back(k);
  }
  std::sort(harmonics.begin(), harmonics.end());
  harmonics.erase(std::unique(harmonics.begin(), harmonics.end()), harmonics.end());
  return harmonics;
}

Complex hold(double frequency_Hz, double step_s) {
  const Complex turn(0.0, 2.0 * std::numbers::pi * frequency_Hz * step_s);
  return (1.0 - std::exp(-turn)) / turn;
}

/// Variance of the mean output at a harmonic, less the part that the input's own noise explains, from the spread of the
/// periods at and around it.
double noise_power(const Spectra& output, const Spectra& input, Complex gain, std::size_t harmonic, std::size_t last) {
  const std::size_t from = harmonic > kNeighbours ? harmonic - kNeighbours : 1;
  const std::size_t to = std::min(harmonic + kNeighbours, last);
  double sum = 0.0;
  for (std::size_t k = from; k <= to; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    sum += ((output.periods.row(row).array() - output.mean[row]) -
            gain * (input.periods.row(row).array() - input.mean[row]))
               .abs2()
               .sum();
  }
  const auto count = static_cast<double>(output.periods.cols());
  return sum / (static_cast<double>(to - from + 1) * count * (count - 1.0));
}

/// Distortion, from the lines that are not excited.
class Distortion {
 public:
  Distortion(const Spectra& output, const Spectra& input, const std::vector<std::size_t>& excited,
             const std::vector<Complex>& gains, std::size_t last)
      : output_(output), input_(input), excited_(excited), gains_(gains), last_(last) {
    all_odd_ = std::all_of(excited.begin(), excited.end(), [](std::size_t k) { return k % 2 == 1; });
  }

  /// Level beside excited line i [dB below its output].
  [[nodiscard]] std::optional<double> even(std::size_t i) const {
    if (!all_odd_) return std::nullopt;
    std::vector<std::size_t> beside;
    for (const std::size_t k : {excited_[i] - 1, excited_[i] + 1}) {
      if (k >= 1 && k <= last_) beside.push_back(k);
    }
    return level(beside, i);
  }

  /// The silent odd harmonic that is nearest to excited line i on a logarithmic axis: at most an octave
  /// away, or its third harmonic.
  [[nodiscard]] std::optional<std::size_t> odd_harmonic(std::size_t i) const {
    if (!all_odd_) return std::nullopt;
    const std::size_t at = excited_[i];
    std::size_t above = at + 2;
    while (above - at <= kReach && !is_silent(above)) above += 2;
    std::size_t below = at - 2;
    while (below < at && at - below <= kReach && !is_silent(below)) below -= 2;  // below 1 it wraps
    const bool has_above = above - at <= kReach && above <= last_ && (above <= 2 * at || above == 3 * at);
    const bool has_below = below < at && at - below <= kReach && 2 * below >= at;
    if (has_above && has_below) return above * below < at * at ? above : below;
    if (has_above) return above;
    return has_below ? std::optional(below) : std::nullopt;
  }

  [[nodiscard]] std::optional<double> odd(std::size_t i) const {
    const auto harmonic = odd_harmonic(i);
    return harmonic ? level({*harmonic}, i) : std::nullopt;
  }

  [[nodiscard]] SilentPowers silent() const {
    if (!all_odd_) return {};
    std::array<double, 2> power{};  // of even and odd lines
    std::array<double, 2> lines{};
    const std::size_t first = excited_.front() > 2 ? excited_.front() - 2 : 1;
    for (std::size_t k = first; k <= std::min(excited_.back() + 2, last_); ++k) {
      const auto at = std::lower_bound(excited_.begin(), excited_.end(), k);
      if (at != excited_.end() && *at == k) continue;
      const auto near = std::min<std::ptrdiff_t>(at - excited_.begin(), std::ssize(excited_) - 1);
      const auto row = static_cast<Eigen::Index>(k);
      power[k % 2] += std::norm(output_.mean[row] - gains_[static_cast<std::size_t>(near)] * input_.mean[row]);
      lines[k % 2] += 1.0;
    }
    const auto mean = [&](std::size_t i) { return lines[i] > 0.0 ? std::optional(power[i] / lines[i]) : std::nullopt; };
    return {.even = mean(0), .odd = mean(1)};
  }

 private:
  [[nodiscard]] bool is_silent(std::size_t k) const { return !std::binary_search(excited_.begin(), excited_.end(), k); }

  [[nodiscard]] std::optional<double> level(const std::vector<std::size_t>& beside, std::size_t i) const {
    if (beside.empty()) return std::nullopt;
    double power = 0.0;
    for (const std::size_t k : beside) {
      const auto row = static_cast<Eigen::Index>(k);
      power += std::norm(output_.mean[row] - gains_[i] * input_.mean[row]);
    }
    power /= static_cast<double>(beside.size());
    return 10.0 * std::log10(power / std::norm(output_.mean[static_cast<Eigen::Index>(excited_[i])]));
  }

  const Spectra& output_;
  const Spectra& input_;
  const std::vector<std::size_t>& excited_;
  const std::vector<Complex>& gains_;
  std::size_t last_;
  bool all_odd_ = false;
};

}  // namespace

FrequencyResponse measure_frequency_response(const Record& record, const Periods& periods,
                                             const std::vector<double>& lines_Hz) {
  if (record.input.size() != record.output.size() || !record.input.allFinite() || !record.output.allFinite()) {
    throw DataError("frequency response: expected as many finite inputs as outputs");
  }
  if (periods.length < 3) throw DataError("frequency response: expected periods of at least 3 rows");
  const PeriodicSignal driven = average_periods(record.output, periods, Drift::remove);
  const Spectra output = spectra_of(driven.periods);
  const Spectra input = spectra_of(average_periods(record.input, periods, Drift::keep).periods);
  const std::vector<std::size_t> harmonics = lines_Hz.empty()
                                                 ? harmonics_that_carry(input.mean, periods)
                                                 : harmonics_of(lines_Hz, input.mean, periods, record.step_s);
  std::vector<Complex> gains;  // between samples, hold included
  for (const std::size_t k : harmonics) {
    const auto row = static_cast<Eigen::Index>(k);
    gains.push_back(output.mean[row] / input.mean[row]);
  }
  const Distortion distortion(output, input, harmonics, gains, highest(periods));
  FrequencyResponse result{.periods = periods,
                           .lines = {},
                           .noise_std = driven.noise_std,
                           .signal_to_noise_dB = driven.signal_to_noise_dB,
                           .drift_range = driven.drift_range,
                           .drift_detected = driven.drift_detected,
                           .silent = distortion.silent()};
  const double period_s = static_cast<double>(periods.length) * record.step_s;
  for (std::size_t i = 0; i < harmonics.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(harmonics[i]);
    LineResponse line;
    line.harmonic = harmonics[i];
    line.frequency_Hz = static_cast<double>(line.harmonic) / period_s;
    const Complex held = hold(line.frequency_Hz, record.step_s);
    line.response = gains[i] / held;
    line.input_amplitude = std::abs(input.mean[row]);
    line.output_amplitude = std::abs(output.mean[row]);
    const double noise = noise_power(output, input, gains[i], line.harmonic, highest(periods));
    // Half of the error's power lies along the response, where it changes the gain.
    line.std = std::sqrt(noise / 2.0) / (line.input_amplitude * std::abs(held));
    line.noise_dB = 10.0 * std::log10(noise / std::norm(output.mean[row]));
    line.even_distortion_dB = distortion.even(i);
    line.odd_distortion_dB = distortion.odd(i);
    if (const auto harmonic = distortion.odd_harmonic(i))
      line.odd_distortion_Hz = static_cast<double>(*harmonic) / period_s;
    result.lines.push_back(line);
  }
  return result;
}

}  // namespace eha::ident
