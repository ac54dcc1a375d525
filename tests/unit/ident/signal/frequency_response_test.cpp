// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/frequency_response.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <thread>
#include <vector>

#include "core/error.hpp"
#include "ident/excitation/excitation.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "ident/fractional/simulate.hpp"
#include "ident/signal/fft.hpp"

namespace eha::ident {
namespace {

using std::numbers::pi;

constexpr double kStep_s = 0.01;
constexpr std::size_t kLength = 2000;

Excitation odd_random(double amplitude_V) {
  return {.kind = OddRandomMultisine{.amplitude_V = amplitude_V, .band = {0.05, 2.0}, .seed = 7}};
}

TEST(RealFft, StaysRightForMoreLengthsThanItKeepsAndFromManyThreads) {
  const auto check = [](std::size_t offset) {
    for (std::size_t round = 0; round < 40; ++round) {
      const RealFft fft(16 + 2 * ((round + offset) % 20));
      std::vector<double> signal(fft.length());
      for (std::size_t n = 0; n < signal.size(); ++n) signal[n] = std::cos(static_cast<double>(3 * n + offset));
      const std::vector<double> before = signal;
      std::vector<std::complex<double>> spectrum(fft.bins());
      fft.forward(signal, spectrum);
      fft.inverse(spectrum, signal);
      for (std::size_t n = 0; n < signal.size(); ++n) {
        ASSERT_NEAR(signal[n] / static_cast<double>(fft.length()), before[n], 1e-14);
      }
    }
  };
  std::vector<std::jthread> threads;
  for (std::size_t k = 0; k < 4; ++k) threads.emplace_back(check, k);
}

Record record_of(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& plant, std::size_t periods,
                 const Excitation& options) {
  Record record;
  record.step_s = kStep_s;
  record.input = excitation(options, kStep_s, kLength).replicate(static_cast<Eigen::Index>(periods), 1);
  record.output = plant(record.input);
  return record;
}

std::vector<double> lines_of(const Excitation& options) { return excited_lines(options, kStep_s, kLength); }

/// Greatest error over the lines, relative to the truth at each.
double worst_error(const FrequencyResponse& measured, const TransferFunction& truth) {
  double worst = 0.0;
  for (const LineResponse& line : measured.lines) {
    const std::complex<double> g = frequency_response(truth, {0.0, 2.0 * pi * line.frequency_Hz});
    worst = std::max(worst, std::abs(line.response - g) / std::abs(g));
  }
  return worst;
}

const TransferFunction kFractional{{{1.0, 0.0}}, {{0.3, 1.6}, {0.5, 0.8}, {1.0, 0.0}}, 0.0};
/// A valve into a cylinder: the slow mode has a time constant of 400 s.
const TransferFunction kNearIntegrating{{{0.5, 0.0}}, {{0.1, 2.0}, {1.0, 1.0}, {0.0025, 0.0}}, 0.0};

TEST(FrequencyResponse, MeetsTheFormulaOfAFractionalModelAtEveryLine) {
  const Excitation options = odd_random(2.0);
  const Record record =
      record_of([](const Eigen::VectorXd& u) { return simulate(kFractional, u, kStep_s); }, 12, options);
  const FrequencyResponse measured =
      measure_frequency_response(record, last_periods(12 * kLength, kLength, 9 * kLength), lines_of(options));
  ASSERT_EQ(measured.lines.size(), lines_of(options).size());
  // Left over: the power-law tail of the start, and what folds back at (2 Hz / 100 Hz)^2.6 = 4e-5.
  EXPECT_LT(worst_error(measured, kFractional), 2e-4);
}

TEST(FrequencyResponse, IsNotBentByTheDriftOfANearIntegratingPlant) {
  Excitation options = odd_random(2.0);
  options.offset_V = 0.3;
  const Record record =
      record_of([](const Eigen::VectorXd& u) { return simulate(kNearIntegrating, u, kStep_s); }, 3, options);
  const Periods periods = last_periods(3 * kLength, kLength, kLength);
  const FrequencyResponse measured = measure_frequency_response(record, periods, lines_of(options));
  EXPECT_TRUE(measured.drift_detected);
  EXPECT_GT(measured.drift_range, 1.0);
  EXPECT_LT(worst_error(measured, kNearIntegrating), 1e-3);

  // The same lines with the drift left in, to show that it matters: the first harmonic alone.
  const PeriodicSignal kept = average_periods(record.output, periods, Drift::keep);
  const PeriodicSignal input = average_periods(record.input, periods, Drift::keep);
  std::complex<double> y;
  std::complex<double> u;
  for (Eigen::Index k = 0; k < kept.mean.size(); ++k) {
    const auto turn = std::polar(1.0, -2.0 * pi * static_cast<double>(measured.lines[0].harmonic) *
                                          static_cast<double>(k) / static_cast<double>(kLength));
    y += turn * kept.mean[k];
    u += turn * input.mean[k];
  }
  const std::complex<double> truth =
      frequency_response(kNearIntegrating, {0.0, 2.0 * pi * measured.lines[0].frequency_Hz});
  EXPECT_GT(std::abs(y / u - truth) / std::abs(truth), 0.05);
}

TEST(FrequencyResponse, StatesStandardDeviationsThatItsErrorsHave) {
  const Excitation options = odd_random(2.0);
  const Record clean =
      record_of([](const Eigen::VectorXd& u) { return simulate(kFractional, u, kStep_s); }, 9, options);
  for (const std::size_t count : {2U, 6U}) {
    const Periods periods{(9 - count) * kLength, kLength, count};
    const FrequencyResponse truth = measure_frequency_response(clean, periods, lines_of(options));
    double share = 0.0;
    double lines = 0.0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      PortableDraw draw(seed);
      Record noisy = clean;
      for (double& y : noisy.output) y += 0.05 * draw.normal();
      const FrequencyResponse measured = measure_frequency_response(noisy, periods, lines_of(options));
      for (std::size_t i = 0; i < measured.lines.size(); ++i) {
        share += std::norm(measured.lines[i].response - truth.lines[i].response) /
                 (2.0 * measured.lines[i].std * measured.lines[i].std);
        lines += 1.0;
      }
    }
    // E of |error|^2 over its own estimate from n real degrees of freedom is n / (n - 2); n is twice 5 (count - 1) save
    // at the lowest line. About 1200 lines scatter by 3.5 %, and at the lowest ones the drift takes its part.
    const double freedom = 10.0 * static_cast<double>(count - 1);
    EXPECT_NEAR(share / lines, freedom / (freedom - 2.0), 0.17) << count << " periods";
  }
}

TEST(FrequencyResponse, StatesTheScatterOfTheGain) {
  const Excitation options = odd_random(2.0);
  const Record clean =
      record_of([](const Eigen::VectorXd& u) { return simulate(kFractional, u, kStep_s); }, 9, options);
  const Periods periods{3 * kLength, kLength, 6};
  const FrequencyResponse truth = measure_frequency_response(clean, periods, lines_of(options));
  double gain = 0.0;
  double stated = 0.0;
  double floor = 0.0;
  constexpr std::size_t kLine = 5;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    PortableDraw draw(seed);
    Record noisy = clean;
    for (double& y : noisy.output) y += 0.05 * draw.normal();
    const LineResponse line = measure_frequency_response(noisy, periods, lines_of(options)).lines[kLine];
    gain += std::pow(std::abs(line.response) - std::abs(truth.lines[kLine].response), 2);
    stated += line.std * line.std;
    floor += line.noise_dB / 200.0;
  }
  // The ratio of two variances of 200 draws scatters by 10 %.
  EXPECT_NEAR(gain / stated, 1.0, 0.3);
  // White noise of variance s^2 leaves 4 s^2 / N in the square of an amplitude from N samples.
  const double amplitude = truth.lines[kLine].output_amplitude;
  const double expected = 4.0 * 0.05 * 0.05 / (6.0 * static_cast<double>(kLength) * amplitude * amplitude);
  EXPECT_NEAR(floor, 10.0 * std::log10(expected), 1.0);
}

/// Lines where each kind of distortion is above -100 dB.
struct Distorted {
  std::size_t even = 0;
  std::size_t odd = 0;
  std::size_t beside_odd = 0;  ///< lines with a silent odd one within an octave
  std::size_t lines = 0;
};

Distorted distortion_of(const std::function<double(double)>& nonlinearity) {
  const Excitation options = odd_random(1.0);
  const Record record =
      record_of([&](const Eigen::VectorXd& u) -> Eigen::VectorXd { return u.unaryExpr(nonlinearity); }, 2, options);
  Distorted distorted;
  for (const LineResponse& line : measure_frequency_response(record, {0, kLength, 2}, lines_of(options)).lines) {
    EXPECT_TRUE(line.even_distortion_dB.has_value());
    distorted.even += line.even_distortion_dB.value_or(0.0) > -100.0 ? 1 : 0;
    distorted.odd += line.odd_distortion_dB.value_or(-200.0) > -100.0 ? 1 : 0;
    distorted.beside_odd += line.odd_distortion_dB ? 1 : 0;
    distorted.lines += 1;
  }
  return distorted;
}

TEST(Distortion, OfACubeIsOddOnly) {
  const Distorted distorted = distortion_of([](double u) { return u + 0.1 * u * u * u; });
  EXPECT_EQ(distorted.even, 0U);
  EXPECT_EQ(distorted.odd, distorted.beside_odd);
  EXPECT_GT(2 * distorted.beside_odd, distorted.lines);
}

TEST(Distortion, OfASquareIsEvenOnly) {
  const Distorted distorted = distortion_of([](double u) { return u + 0.1 * u * u; });
  EXPECT_EQ(distorted.odd, 0U);
  EXPECT_EQ(distorted.even, distorted.lines);
}

TEST(Distortion, OfALinearPlantIsNone) {
  const Distorted distorted = distortion_of([](double u) { return 3.0 * u; });
  EXPECT_EQ(distorted.even + distorted.odd, 0U);
}

TEST(Distortion, HasTheLevelOfTheHarmonicsThatASineMakes) {
  const Excitation options{
      .kind = Multisine{{{0.5, 1.0, 0.0}, {2.5, 1.0, 0.0}}}};  // harmonics 1 and 5 of 0.5 Hz: 3 is silent between them
  const Record record = record_of(
      [](const Eigen::VectorXd& u) -> Eigen::VectorXd { return u.array() + 0.1 * u.array().square(); }, 2, options);
  const FrequencyResponse measured = measure_frequency_response(record, {0, 200, 20}, lines_of(options));
  ASSERT_EQ(measured.lines.size(), 2U);
  // (cos a + cos 5a)^2 = 1 + (cos 2a + cos 10a) / 2 + cos 4a + cos 6a.
  ASSERT_TRUE(measured.lines[0].even_distortion_dB.has_value());
  EXPECT_NEAR(*measured.lines[0].even_distortion_dB, 20.0 * std::log10(0.1 * 0.5), 1e-6);
  EXPECT_NEAR(*measured.lines[1].even_distortion_dB, 20.0 * std::log10(0.1), 1e-6);
  for (const LineResponse& line : measured.lines) {  // harmonic 3, the third one of the first line
    ASSERT_TRUE(line.odd_distortion_dB.has_value());
    EXPECT_LT(*line.odd_distortion_dB, -200.0);
  }
}

TEST(Distortion, IsThatOfTheNearestSilentLine) {
  // Odd harmonics 3 to 19 of 0.1 Hz but 13, of an output that falls with frequency: 1 and 13 are silent.
  std::vector<Tone> tones;
  for (const int k : {3, 5, 7, 9, 11, 15, 17, 19}) tones.push_back({0.1 * k, 1.0, 0.7 * k * k});
  const Excitation options{.kind = Multisine{tones}};
  const auto integrate = [](const Eigen::VectorXd& u) -> Eigen::VectorXd {
    Eigen::VectorXd y(u.size());
    double sum = 0.0;
    for (Eigen::Index k = 0; k < u.size(); ++k) {
      y[k] = sum + 1.0 * std::cos(2.0 * std::numbers::pi * static_cast<double>(k) / 1000.0) +
             0.01 * std::cos(2.0 * std::numbers::pi * 13.0 * static_cast<double>(k) / 1000.0);
      sum += 0.01 * u[k];
    }
    return y;
  };
  const FrequencyResponse measured =
      measure_frequency_response(record_of(integrate, 2, options), {0, 1000, 4}, lines_of(options));
  ASSERT_EQ(measured.lines.size(), 8U);
  EXPECT_FALSE(measured.lines[0].odd_distortion_dB.has_value());  // 0.3 Hz: 0.1 and 1.3 Hz are farther than an octave
  EXPECT_FALSE(measured.lines[1].odd_distortion_dB.has_value());
  for (const std::size_t i : {2U, 3U, 4U, 5U}) {  // 0.7 to 1.5 Hz
    const LineResponse& line = measured.lines[i];
    ASSERT_TRUE(line.odd_distortion_dB.has_value()) << line.frequency_Hz;
    EXPECT_NEAR(*line.odd_distortion_Hz, 1.3, 1e-9);
    EXPECT_NEAR(*line.odd_distortion_dB, 20.0 * std::log10(0.01 / line.output_amplitude), 0.1) << line.frequency_Hz;
  }
  EXPECT_NEAR(*measured.lines[7].odd_distortion_Hz, 2.1, 1e-9);
}

TEST(Distortion, IsNotStatedWhereEvenHarmonicsAreExcited) {
  const Excitation options{.kind = Multisine{{{0.05, 1.0, 0.3}, {0.2, 1.0, 0.1}}}};  // harmonics 1 and 4
  const Record record = record_of([](const Eigen::VectorXd& u) { return u; }, 2, options);
  for (const LineResponse& line : measure_frequency_response(record, {0, kLength, 2}, {0.05, 0.2}).lines) {
    EXPECT_FALSE(line.even_distortion_dB.has_value());
    EXPECT_FALSE(line.odd_distortion_dB.has_value());
  }
}

TEST(FrequencyResponse, FindsTheLinesThatCarryTheInputWhereNoneAreNamed) {
  const Excitation options{.kind = Multisine{{{0.05, 1.0, 0.3}, {0.2, 0.5, 0.1}, {0.65, 0.02, 0.0}}}};
  const Record record = record_of([](const Eigen::VectorXd& u) { return u; }, 2, options);
  const FrequencyResponse measured = measure_frequency_response(record, {0, kLength, 2}, {});
  ASSERT_EQ(measured.lines.size(), 2U);
  EXPECT_NEAR(measured.lines[0].frequency_Hz, 0.05, 1e-12);
  EXPECT_NEAR(measured.lines[1].input_amplitude, 0.5, 1e-9);
}

TEST(FrequencyResponse, RefusesLinesThatThePeriodOrTheInputDoesNotHold) {
  const Excitation options{.kind = Multisine{{{0.05, 1.0, 0.3}}}};
  Record record = record_of([](const Eigen::VectorXd& u) { return u; }, 2, options);
  const Periods periods{0, kLength, 2};
  EXPECT_THROW(static_cast<void>(measure_frequency_response(record, periods, {0.07})), DataError);
  EXPECT_THROW(static_cast<void>(measure_frequency_response(record, periods, {0.1})), DataError);
  EXPECT_THROW(static_cast<void>(measure_frequency_response(record, periods, {60.0})), DataError);
  record.input.setConstant(1.0);
  EXPECT_THROW(static_cast<void>(measure_frequency_response(record, periods, {})), DataError);
  record.output[5] = std::nan("");
  EXPECT_THROW(static_cast<void>(measure_frequency_response(record, periods, {0.05})), DataError);
}

}  // namespace
}  // namespace eha::ident
