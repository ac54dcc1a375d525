// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/realisations.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "core/error.hpp"
#include "ident/excitation/excitation.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "tests/unit/ident/signal/nonlinear_plants.hpp"

namespace eha::ident {
namespace {

constexpr double kStep_s = 0.01;
constexpr std::size_t kLength = 1000;
constexpr std::size_t kPeriods = 3;
constexpr std::size_t kCount = 6;
constexpr std::size_t kSamples = kCount * kPeriods * kLength;
constexpr RealisationRows kRows{0, kLength, kPeriods, kCount};

Excitation six() {
  return {.kind = OddRandomMultisine{.amplitude_V = 3.0,
                                     .band = {0.1, 5.0},
                                     .realisations = static_cast<int>(kCount),
                                     .periods = static_cast<int>(kPeriods),
                                     .seed = 4}};
}

Record record_of(const nonlinear::Plant& plant, double noise) {
  Record record;
  record.step_s = kStep_s;
  record.input = excitation(six(), kStep_s, kSamples);
  record.output = plant.response(record.input);
  PortableDraw draw(9);
  for (double& y : record.output) y += noise * draw.normal();
  return record;
}

std::vector<double> lines() { return excited_lines(six(), kStep_s, kSamples); }

TEST(Realisations, ShowNoDistortionOfALinearPlant) {
  const FrequencyResponse found = measure_realisations(record_of({}, 0.01), kRows, lines());
  EXPECT_EQ(found.realisations, kCount);
  ASSERT_TRUE(found.levels);
  EXPECT_FALSE(found.levels->excited_dB);
  EXPECT_FALSE(found.levels->even_dB);
  EXPECT_FALSE(found.levels->odd_dB);
  const double angle = nonlinear::Resonance{}.angle_rad;
  const double radius = nonlinear::Resonance{}.radius;
  for (const LineResponse& line : found.lines) {
    const std::complex<double> z = std::polar(1.0, 2.0 * std::numbers::pi * line.frequency_Hz * kStep_s);
    const double rest = 1.0 - 2.0 * radius * std::cos(angle) + radius * radius;
    const std::complex<double> g = rest * z / (z * z - 2.0 * radius * std::cos(angle) * z + radius * radius);
    const std::complex<double> turn(0.0, 2.0 * std::numbers::pi * line.frequency_Hz * kStep_s);
    EXPECT_LT(std::abs(line.response * (1.0 - std::exp(-turn)) / turn - g), 6.0 * line.std) << line.frequency_Hz;
  }
}

TEST(Realisations, TellEvenFromOddDistortion) {
  nonlinear::Plant even;
  even.square = 0.1;
  const FrequencyResponse squared = measure_realisations(record_of(even, 1e-4), kRows, lines());
  EXPECT_GT(squared.levels->even_dB.value_or(-200.0), -40.0);
  EXPECT_LT(squared.levels->odd_dB.value_or(-200.0), -60.0);
  nonlinear::Plant odd;
  odd.cube = 0.05;
  const FrequencyResponse cubed = measure_realisations(record_of(odd, 1e-4), kRows, lines());
  EXPECT_LT(cubed.levels->even_dB.value_or(-200.0), -60.0);
  EXPECT_GT(cubed.levels->odd_dB.value_or(-200.0), -40.0);
  // An odd nonlinearity reaches excited and silent odd lines alike.
  EXPECT_NEAR(*cubed.levels->excited_dB, *cubed.levels->odd_dB, 3.0);
}

TEST(Realisations, DoNotDependOnTheUnit) {
  nonlinear::Plant plant;
  plant.cube = 0.05;
  Record record = record_of(plant, 0.01);
  const FrequencyResponse inches = measure_realisations(record, kRows, lines());
  record.output *= 25.4;
  const FrequencyResponse millimetres = measure_realisations(record, kRows, lines());
  EXPECT_NEAR(*inches.levels->excited_dB, *millimetres.levels->excited_dB, 1e-9);
  EXPECT_NEAR(inches.levels->noise_dB, millimetres.levels->noise_dB, 1e-9);
  EXPECT_NEAR(millimetres.lines[3].std, 25.4 * inches.lines[3].std, 1e-9);
}

TEST(Realisations, StateTheScatterOfTheGain) {
  // The first three realisations against the last three.
  nonlinear::Plant plant;
  plant.cube = 0.05;
  const Record record = record_of(plant, 0.002);
  const FrequencyResponse first = measure_realisations(record, {0, kLength, kPeriods, 3}, lines());
  const FrequencyResponse last = measure_realisations(record, {3 * kPeriods * kLength, kLength, kPeriods, 3}, lines());
  double difference = 0.0;
  double stated = 0.0;
  for (std::size_t k = 0; k < first.lines.size(); ++k) {
    difference += std::norm(first.lines[k].response - last.lines[k].response);
    stated += 2.0 * (std::pow(first.lines[k].std, 2) + std::pow(last.lines[k].std, 2));
  }
  // 19 lines, each with two degrees of freedom above and eight beneath: within a factor of two.
  EXPECT_GT(difference / stated, 0.5);
  EXPECT_LT(difference / stated, 2.0);
}

TEST(Realisations, RefuseFewerThanTwoOrFewerThanThreePeriods) {
  const Record record = record_of({}, 0.01);
  EXPECT_THROW(static_cast<void>(measure_realisations(record, {0, kLength, kPeriods, 1}, lines())), DataError);
  EXPECT_THROW(static_cast<void>(measure_realisations(record, {0, kLength, 2, kCount}, lines())), DataError);
  EXPECT_THROW(static_cast<void>(measure_realisations(record, {1, kLength, kPeriods, kCount}, lines())), DataError);
}

}  // namespace
}  // namespace eha::ident
