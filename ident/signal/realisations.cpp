// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/realisations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/error.hpp"
#include "ident/signal/periods.hpp"

namespace eha::ident {
namespace {

constexpr double kChance = 2.0;  // standard errors above which a difference of powers is more than chance
constexpr std::size_t kFewestRealisations = 2;
constexpr std::size_t kFewestPeriodsOfEach = 3;

double power_of(double level_dB) { return std::pow(10.0, level_dB / 10.0); }
double level_of(double power) { return 10.0 * std::log10(power); }

/// Powers at an excited line, or their sums.
struct Powers {
  double output = 0.0;
  double noise = 0.0;
  double spread = 0.0;  ///< of the realisations

  void add(const Powers& other) {
    output += other.output;
    noise += other.noise;
    spread += other.spread;
  }
};

/// Returns the part of a power that noise does not explain, below the output; none if chance may explain it.
/// @param values, noise_values  numbers of independent complex values that `power` and the noise are means of
std::optional<double> beyond_noise_dB(double power, const Powers& powers, double values, double noise_values) {
  const double chance = kChance * std::sqrt(1.0 / values + 1.0 / noise_values);
  if (!(power > powers.noise * (1.0 + chance))) return std::nullopt;
  return level_of((power - powers.noise) / powers.output);
}

}  // namespace

FrequencyResponse measure_realisations(const Record& record, const RealisationRows& rows,
                                       const std::vector<double>& lines_Hz) {
  if (rows.count < kFewestRealisations || rows.periods < kFewestPeriodsOfEach) {
    throw DataError(fmt::format("realisations: expected at least {} of at least {} periods each, got {} of {}",
                                kFewestRealisations, kFewestPeriodsOfEach, rows.count, rows.periods));
  }
  const std::size_t each = rows.length * rows.periods;
  std::vector<FrequencyResponse> all;
  for (std::size_t m = 0; m < rows.count; ++m) {
    const Periods periods{rows.first + m * each + rows.length, rows.length, rows.periods - 1};
    all.push_back(measure_frequency_response(record, periods, lines_Hz));
  }
  FrequencyResponse result = all.front();
  const auto count = static_cast<double>(rows.count);
  const double noise_values = count * static_cast<double>(rows.periods - 2);
  result.realisations = rows.count;
  result.periods.count = rows.count * (rows.periods - 1);
  result.noise_std = 0.0;
  result.signal_to_noise_dB = 0.0;
  for (const FrequencyResponse& one : all) {
    result.noise_std += one.noise_std * one.noise_std / count;
    result.signal_to_noise_dB += one.signal_to_noise_dB / count;
    result.drift_range = std::max(result.drift_range, one.drift_range);
    result.drift_detected = result.drift_detected || one.drift_detected;
  }
  result.noise_std = std::sqrt(result.noise_std);
  Powers band;
  for (std::size_t k = 0; k < result.lines.size(); ++k) {
    LineResponse& line = result.lines[k];
    line.response = 0.0;
    double input = 0.0;
    double held = 0.0;  // power of the held input, by which a variance of G becomes one of the output
    Powers powers;
    // Beside the same lines in every realisation.
    std::optional<double> even = line.even_distortion_dB ? std::optional(0.0) : std::nullopt;
    std::optional<double> odd = line.odd_distortion_dB ? std::optional(0.0) : std::nullopt;
    for (const FrequencyResponse& one : all) {
      const LineResponse& seen = one.lines[k];
      const double output = seen.output_amplitude * seen.output_amplitude;
      line.response += seen.response / count;
      input += seen.input_amplitude / count;
      held += output / std::norm(seen.response) / count;
      powers.output += output / count;
      powers.noise += power_of(seen.noise_dB) * output / count;
      if (even) *even += power_of(seen.even_distortion_dB.value_or(0.0)) * output / count;
      if (odd) *odd += power_of(seen.odd_distortion_dB.value_or(0.0)) * output / count;
    }
    double variance = 0.0;
    for (const FrequencyResponse& one : all) variance += std::norm(one.lines[k].response - line.response);
    variance /= count - 1.0;
    powers.spread = variance * held;
    line.std = std::sqrt(variance / (2.0 * count));
    line.input_amplitude = input;
    line.output_amplitude = std::sqrt(powers.output);
    line.noise_dB = level_of(powers.noise / powers.output);
    line.distortion_dB = beyond_noise_dB(powers.spread, powers, count - 1.0, noise_values);
    if (even) line.even_distortion_dB = level_of(*even / powers.output);
    if (odd) line.odd_distortion_dB = level_of(*odd / powers.output);
    band.add(powers);
  }
  const auto lines = static_cast<double>(result.lines.size());
  DistortionLevels levels;
  levels.noise_dB = level_of(band.noise / band.output);
  levels.excited_dB = beyond_noise_dB(band.spread, band, lines * (count - 1.0), lines * noise_values);
  // Mean power of a silent line of each kind over the realisations. `band` holds sums over the lines, hence the factor
  // `lines`.
  const auto mean = [&](std::optional<double> SilentPowers::*kind) -> std::optional<double> {
    if (!(result.silent.*kind)) return std::nullopt;
    double sum = 0.0;
    for (const FrequencyResponse& one : all) sum += *(one.silent.*kind);
    return sum / count;
  };
  result.silent = {.even = mean(&SilentPowers::even), .odd = mean(&SilentPowers::odd)};
  if (result.silent.even) {
    levels.even_dB = beyond_noise_dB(*result.silent.even * lines, band, lines * count, lines * noise_values);
  }
  if (result.silent.odd) {
    // One odd line in four is silent.
    levels.odd_dB = beyond_noise_dB(*result.silent.odd * lines, band, lines * count / 3.0, lines * noise_values);
  }
  result.levels = levels;
  return result;
}

}  // namespace eha::ident
