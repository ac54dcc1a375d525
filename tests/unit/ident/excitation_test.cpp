// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/excitation.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <set>

#include "core/error.hpp"
#include "ident/excitation/portable_draw.hpp"

namespace eha::ident {
namespace {

using Vector = Eigen::VectorXd;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

ExcitationOptions paper() {
  ExcitationOptions options;
  options.tones = {{0.05, 1.9, 0.3}, {0.2, 1.6, 1.9}, {0.65, 1.5, 4.2}};
  return options;
}

ExcitationOptions band(ExcitationKind kind, double low_Hz, double high_Hz) {
  ExcitationOptions options;
  options.kind = kind;
  options.amplitude_V = 3.0;
  options.frequency_min_Hz = low_Hz;
  options.frequency_max_Hz = high_Hz;
  return options;
}

/// Amplitude of one harmonic of a table that is one period, by the sum that defines it.
double line_amplitude(const Vector& table, Eigen::Index harmonic) {
  std::complex<double> sum = 0.0;
  const Eigen::Index count = table.size();
  for (Eigen::Index k = 0; k < count; ++k) {
    sum += table(k) * std::polar(1.0, -kTwoPi * static_cast<double>(harmonic * k % count) / static_cast<double>(count));
  }
  return 2.0 * std::abs(sum) / static_cast<double>(count);
}

TEST(PortableDraw, GivesTheNumbersTheStandardFixesForTheGenerator) {
  // [rand.predef]: the 10000th draw of a default-seeded mt19937_64 (seed 5489) is 9981545732273789042.
  PortableDraw draw(5489);
  double last = 0.0;
  for (int i = 0; i < 10000; ++i) last = draw.uniform();
  EXPECT_EQ(last, static_cast<double>(9981545732273789042ULL >> 11U) * 0x1p-53);
}

TEST(PortableDraw, IsUniformAndNormalInItsFirstMoments) {
  PortableDraw draw(3);
  constexpr int kDraws = 100000;
  double sum = 0.0;
  double squares = 0.0;
  std::array<int, 3> counts{};
  for (int i = 0; i < kDraws; ++i) {
    const double value = draw.normal();
    sum += value;
    squares += value * value;
    ++counts[draw.below(3)];
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 5.0 / std::sqrt(kDraws));
  EXPECT_NEAR(squares / kDraws, 1.0, 5.0 * std::sqrt(2.0 / kDraws));
  for (const int count : counts) EXPECT_NEAR(count, kDraws / 3.0, 5.0 * std::sqrt(kDraws * 2.0 / 9.0));
}

TEST(Multisine, IsTheSumOfItsTonesPlusTheOffset) {
  ExcitationOptions options = paper();
  options.offset_V = 0.25;
  const Vector table = excitation(options, 0.001, 50000);
  ASSERT_EQ(table.size(), 50000);
  for (const Eigen::Index k : {0, 1, 777, 49999}) {
    const double t = static_cast<double>(k) / 1000.0;
    const double expected = 0.25 + 1.9 * std::cos(kTwoPi * 0.05 * t + 0.3) + 1.6 * std::cos(kTwoPi * 0.2 * t + 1.9) +
                            1.5 * std::cos(kTwoPi * 0.65 * t + 4.2);
    EXPECT_NEAR(table(k), expected, 1e-12);
  }
  EXPECT_EQ(excited_lines(options, 0.001, 50000), (std::vector<double>{0.05, 0.2, 0.65}));
}

TEST(Multisine, SuperposesItsTones) {
  const ExcitationOptions all = paper();
  Vector sum = Vector::Zero(1000);
  for (const Tone& tone : all.tones) {
    ExcitationOptions one;
    one.kind = ExcitationKind::sine;
    one.tones = {tone};
    sum += excitation(one, 0.01, 1000);
  }
  EXPECT_LT((excitation(all, 0.01, 1000) - sum).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(CrestFactor, IsTheSquareRootOfTwoForASineAndOneForASquareWave) {
  ExcitationOptions sine;
  sine.kind = ExcitationKind::sine;
  sine.tones = {{1.0, 2.5, 0.0}};
  sine.offset_V = 4.0;
  EXPECT_NEAR(crest_factor(excitation(sine, 0.001, 1000)), std::numbers::sqrt2, 1e-12);
  EXPECT_NEAR(crest_factor(Eigen::Vector4d(1, -1, -1, 1)), 1.0, 1e-15);
}

TEST(CrestFactor, RefusesASignalWithoutVariation) {
  EXPECT_THROW((void)crest_factor(Vector(0)), DataError);
  EXPECT_THROW((void)crest_factor(Vector::Constant(9, 0.1)), DataError);
}

TEST(OddRandomMultisine, ExcitesThreeOfEachFourOddHarmonicsOfTheBandAndNothingElse) {
  const ExcitationOptions options = band(ExcitationKind::odd_random_multisine, 0.1, 3.2);
  const Vector table = excitation(options, 0.01, 1000);  // 10 s: harmonics of 0.1 Hz, odd ones 1, 3, .. 31
  std::set<Eigen::Index> excited;
  for (const double line_Hz : excited_lines(options, 0.01, 1000)) excited.insert(std::lround(line_Hz * 10.0));
  EXPECT_EQ(excited.size(), 12U);
  double common = 0.0;
  for (Eigen::Index k = 0; k <= 500; ++k) {
    const double amplitude = line_amplitude(table, k);
    if (excited.contains(k)) {
      EXPECT_EQ(k % 2, 1);
      if (common == 0.0) common = amplitude;
      EXPECT_NEAR(amplitude, common, 1e-12);
    } else {
      EXPECT_LT(amplitude, 1e-12) << "harmonic " << k;
    }
  }
  EXPECT_GT(common, 0.1);
  for (int group = 0; group < 4; ++group) {
    int silent = 0;
    for (int i = 0; i < 4; ++i) silent += excited.contains(8 * group + 2 * i + 1) ? 0 : 1;
    EXPECT_EQ(silent, 1);
  }
}

TEST(OddRandomMultisine, HasItsPeakAndALowCrestFactor) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    ExcitationOptions options = band(ExcitationKind::odd_random_multisine, 0.05, 5.0);
    options.seed = seed;
    const Vector table = excitation(options, 0.01, 2000);
    EXPECT_NEAR(table.cwiseAbs().maxCoeff(), 3.0, 1e-12);
    EXPECT_LT(crest_factor(table), 2.6) << "seed " << seed;
  }
}

TEST(Gaussian, KeepsToItsBandAndItsPeak) {
  const ExcitationOptions options = band(ExcitationKind::gaussian, 0.5, 2.0);
  const Vector table = excitation(options, 0.01, 1000);
  EXPECT_NEAR(table.cwiseAbs().maxCoeff(), 3.0, 1e-12);
  for (Eigen::Index k = 0; k <= 500; ++k) {
    if (k < 5 || k > 20) {
      EXPECT_LT(line_amplitude(table, k), 1e-12) << "harmonic " << k;
    }
  }
  EXPECT_EQ(excited_lines(options, 0.01, 1000).size(), 16U);
}

TEST(Gaussian, HasTheKurtosisOfANormalDistribution) {
  const Vector table = excitation(band(ExcitationKind::gaussian, 0.0, 20.0), 0.01, 20000);
  const Eigen::ArrayXd centred = table.array() - table.mean();
  EXPECT_NEAR(centred.pow(4).mean() / std::pow(centred.square().mean(), 2), 3.0, 0.4);
}

TEST(Prms, HoldsEquidistantLevelsForItsHoldTime) {
  ExcitationOptions options = band(ExcitationKind::prms, 0.0, 0.0);
  options.levels = 5;
  options.hold_s = 0.05;
  const Vector table = excitation(options, 0.001, 10000);
  std::set<double> levels;
  for (Eigen::Index k = 0; k < table.size(); ++k) {
    levels.insert(table(k));
    if (k % 50 != 0) {
      ASSERT_EQ(table(k), table(k - 1));
    }
  }
  EXPECT_EQ(levels, (std::set<double>{-3.0, -1.5, 0.0, 1.5, 3.0}));
}

TEST(Chirp, SweepsFromTheLowestToTheHighestFrequency) {
  const Vector table = excitation(band(ExcitationKind::chirp, 1.0, 5.0), 0.001, 10000);
  EXPECT_EQ(table(0), 0.0);
  EXPECT_LE(table.cwiseAbs().maxCoeff(), 3.0);
  // 5 s at 2 Hz on average are 10 periods, each with two sign changes; then 5 s at 4 Hz.
  const auto sign_changes = [&](Eigen::Index from, Eigen::Index to) {
    int changes = 0;
    for (Eigen::Index k = from + 1; k < to; ++k) changes += table(k) * table(k - 1) < 0.0 ? 1 : 0;
    return changes;
  };
  EXPECT_NEAR(sign_changes(0, 5000), 20, 1);
  EXPECT_NEAR(sign_changes(5000, 10000), 40, 1);
}

TEST(Step, StepsAtTheTickOfItsHoldTime) {
  ExcitationOptions options = band(ExcitationKind::step, 0.0, 0.0);
  options.hold_s = 0.3;
  options.offset_V = -1.0;
  const Vector table = excitation(options, 0.1, 6);
  EXPECT_EQ(table, (Vector(6) << -1, -1, -1, 2, 2, 2).finished());
}

TEST(Excitation, RepeatsItselfForOneSeedAndDiffersForAnother) {
  for (const ExcitationKind kind :
       {ExcitationKind::odd_random_multisine, ExcitationKind::gaussian, ExcitationKind::prms}) {
    ExcitationOptions options = band(kind, 0.2, 5.0);
    options.levels = 7;
    options.hold_s = 0.1;
    const Vector first = excitation(options, 0.01, 1000);
    EXPECT_EQ(first, excitation(options, 0.01, 1000));
    options.seed = 2;
    EXPECT_NE(first, excitation(options, 0.01, 1000));
  }
}

TEST(Excitation, ScalesWithItsAmplitude) {
  for (const ExcitationKind kind : {ExcitationKind::odd_random_multisine, ExcitationKind::gaussian,
                                    ExcitationKind::prms, ExcitationKind::chirp, ExcitationKind::step}) {
    ExcitationOptions options = band(kind, 0.2, 5.0);
    options.levels = 7;
    options.hold_s = 0.1;
    const Vector single = excitation(options, 0.01, 1000);
    options.amplitude_V *= 2.0;
    EXPECT_LT((excitation(options, 0.01, 1000) - 2.0 * single).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(Excitation, RefusesOptionsThatMakeNoSense) {
  const auto refused = [](ExcitationOptions options, double step_s = 0.01, std::size_t samples = 1000) {
    EXPECT_THROW((void)excitation(options, step_s, samples), ConfigError);
  };
  refused(paper(), 0.0);
  refused(paper(), -0.1);
  refused(paper(), 0.01, 0);
  ExcitationOptions options;
  refused(options);  // no tones
  options = paper();
  options.kind = ExcitationKind::sine;
  refused(options);  // three tones
  options = paper();
  options.tones[1].frequency_Hz = 0.0;
  refused(options);
  options = paper();
  options.tones[1].amplitude_V = std::numeric_limits<double>::quiet_NaN();
  refused(options);
  for (const ExcitationKind kind :
       {ExcitationKind::odd_random_multisine, ExcitationKind::gaussian, ExcitationKind::chirp}) {
    refused(band(kind, 5.0, 5.0));
    refused(band(kind, -1.0, 5.0));
  }
  for (const ExcitationKind kind : {ExcitationKind::odd_random_multisine, ExcitationKind::gaussian}) {
    refused(band(kind, 1.01, 1.09));  // between two multiples of 0.1 Hz
    refused(band(kind, 1.0, 50.0));   // Nyquist
  }
  refused(band(ExcitationKind::odd_random_multisine, 0.15, 0.25));  // 0.2 Hz only, an even multiple
  refused(band(ExcitationKind::step, 0.0, 0.0));                    // no hold time
  options = band(ExcitationKind::prms, 0.0, 0.0);
  options.hold_s = 0.1;
  options.levels = 2;
  refused(options);
}

}  // namespace
}  // namespace eha::ident
