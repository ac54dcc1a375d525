// SPDX-License-Identifier: GPL-3.0-or-later
// Noise and distortion of fifty nonlinear plants as one record of several realisations shows them, against their truth
// from many realisations without noise. Twenty seconds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <span>
#include <vector>

#include "ident/excitation/excitation.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "ident/signal/fft.hpp"
#include "ident/signal/realisations.hpp"
#include "tests/unit/ident/signal/nonlinear_plants.hpp"

namespace eha::ident {
namespace {

constexpr double kStep_s = 0.01;
constexpr std::size_t kLength = 2000;
constexpr std::size_t kPeriods = 3;
constexpr std::size_t kMeasured = 50;  ///< realisations
constexpr std::size_t kTrue = 250;
constexpr double kNoisePole = 0.6;
constexpr double kAllowed_dB = 1.0;

Excitation odd_random(std::size_t realisations, std::uint64_t seed) {
  return {.kind = OddRandomMultisine{.amplitude_V = 3.0,
                                     .band = {0.05, 5.0},
                                     .realisations = static_cast<int>(realisations),
                                     .periods = static_cast<int>(kPeriods),
                                     .seed = seed}};
}

/// Amplitudes of the harmonics of one period.
Eigen::VectorXcd spectrum(const Eigen::Ref<const Eigen::VectorXd>& period) {
  const RealFft fft(kLength);
  Eigen::VectorXcd bins(static_cast<Eigen::Index>(fft.bins()));
  const Eigen::VectorXd copy = period;
  fft.forward(std::span<const double>(copy.data(), kLength), std::span<std::complex<double>>(bins.data(), fft.bins()));
  return bins * (2.0 / static_cast<double>(kLength));
}

/// Mean powers of a line, the output's and what the distortion adds.
struct Truth {
  double output = 0.0;
  double excited = 0.0;
  double even = 0.0;
  double odd = 0.0;
};

/// From the last periods of many realisations.
Truth truth_of(const nonlinear::Plant& plant, const Eigen::VectorXd& input, const std::vector<std::size_t>& lines) {
  const Eigen::VectorXd output = plant.response(input);
  std::vector<Eigen::VectorXcd> y;
  std::vector<Eigen::VectorXcd> u;
  for (std::size_t m = kMeasured; m < kMeasured + kTrue; ++m) {  // none of those that are measured
    const auto last = static_cast<Eigen::Index>(((m + 1) * kPeriods - 1) * kLength);
    y.push_back(spectrum(output.segment(last, kLength)));
    u.push_back(spectrum(input.segment(last, kLength)));
  }
  Truth truth;
  std::vector<bool> is_excited(kLength, false);
  for (const std::size_t k : lines) is_excited[k] = true;
  double even_lines = 0.0;
  double odd_lines = 0.0;
  const auto count = static_cast<double>(kTrue);
  for (std::size_t k = std::max<std::size_t>(lines.front(), 3) - 2; k <= lines.back() + 2; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    double power = 0.0;
    for (const auto& bins : y) power += std::norm(bins[row]) / count;
    if (k % 2 == 0) {
      truth.even += power;
      even_lines += 1.0;
    } else if (!is_excited[k]) {
      truth.odd += power;
      odd_lines += 1.0;
    } else {
      std::complex<double> gain;
      for (std::size_t m = 0; m < kTrue; ++m) gain += y[m][row] / u[m][row] / count;
      for (std::size_t m = 0; m < kTrue; ++m) truth.excited += std::norm(y[m][row] - gain * u[m][row]) / (count - 1.0);
      truth.output += power;
    }
  }
  truth.even /= even_lines;
  truth.odd /= odd_lines;
  truth.excited /= static_cast<double>(lines.size());
  truth.output /= static_cast<double>(lines.size());
  return truth;
}

/// Mean power at the lines of an AR(1) noise, in the mean of all periods but the first.
double noise_at(const std::vector<std::size_t>& lines, double innovation) {
  double sum = 0.0;
  for (const std::size_t k : lines) {
    const double turn = -2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(kLength);
    sum += 4.0 * innovation * innovation / static_cast<double>(kLength) /
           std::norm(1.0 - kNoisePole * std::polar(1.0, turn));
  }
  return sum / static_cast<double>(lines.size() * (kPeriods - 1));
}

double decibels(double ratio) { return 10.0 * std::log10(ratio); }

class DistortionLevelsOf : public testing::TestWithParam<int> {};

TEST_P(DistortionLevelsOf, AreWithinOneDecibelOfTheTruth) {
  const nonlinear::Plant plant = nonlinear::plant(GetParam());
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const Excitation measured_kind = odd_random(kMeasured, seed);
  const std::size_t samples = kMeasured * kPeriods * kLength;
  const std::vector<double> lines_Hz = excited_lines(measured_kind, kStep_s, samples);
  std::vector<std::size_t> lines;
  for (const double f : lines_Hz) lines.push_back(static_cast<std::size_t>(std::lround(f * kStep_s * kLength)));
  Record record;
  record.step_s = kStep_s;
  record.input = excitation(measured_kind, kStep_s, samples);
  // More realisations have a higher peak among them and so smaller lines.
  Eigen::VectorXd many =
      excitation(odd_random(kMeasured + kTrue, seed), kStep_s, (kMeasured + kTrue) * kPeriods * kLength);
  const auto first = static_cast<Eigen::Index>(lines.front());
  many *= std::abs(spectrum(record.input.segment(kLength, kLength))[first]) /
          std::abs(spectrum(many.segment(kLength, kLength))[first]);
  const Truth truth = truth_of(plant, many, lines);
  record.output = plant.response(record.input);
  PortableDraw draw(seed + 77);
  double innovation = std::sqrt(truth.output * kLength) * std::pow(10.0, -2.2 - 0.6 * draw.uniform());
  // A plant that is nearly linear is compared beside less noise.
  while (noise_at(lines, innovation) > std::max({truth.excited, truth.even, truth.odd})) innovation *= 0.5;
  double noise = 0.0;
  for (double& y : record.output) {
    noise = kNoisePole * noise + innovation * draw.normal();
    y += noise;
  }
  const FrequencyResponse found = measure_realisations(record, {0, kLength, kPeriods, kMeasured}, lines_Hz);
  ASSERT_TRUE(found.levels);
  const double noise_power = noise_at(lines, innovation);
  EXPECT_NEAR(found.levels->noise_dB, decibels(noise_power / truth.output), kAllowed_dB);
  const auto compare = [&](const char* what, const std::optional<double>& level_dB, double power) {
    // Distortion below the noise is hidden by the noise's own scatter.
    if (power < noise_power) return 0;
    EXPECT_TRUE(level_dB) << what;
    EXPECT_NEAR(level_dB.value_or(0.0), decibels(power / truth.output), kAllowed_dB)
        << what << ", noise " << decibels(noise_power / truth.output);
    return 1;
  };
  int compared = compare("at the lines", found.levels->excited_dB, truth.excited);
  compared += compare("even", found.levels->even_dB, truth.even);
  compared += compare("odd", found.levels->odd_dB, truth.odd);
  EXPECT_GE(compared, 1);
}

INSTANTIATE_TEST_SUITE_P(Fifty, DistortionLevelsOf, testing::Range(1, 51));

}  // namespace
}  // namespace eha::ident
